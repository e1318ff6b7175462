/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* Overlap of two unit spheres; prints it, and the version of the library. */
#include <ellgran.h>

#include <stdio.h>

int main(void)
{
  EllgranBody i = ELLGRAN_INIT(EllgranBody), j;
  EllgranContactGeometry geometry = ELLGRAN_INIT(EllgranContactGeometry);
  i.quaternion[0] = i.semi_axes[0] = i.semi_axes[1] = i.semi_axes[2] = 1;
  i.mass = 1;
  i.particle_type = 1;
  i.identifier = 1;
  j = i;
  j.position[0] = 1.5;
  if (ellgran_contact_geometry(NULL, &i, &j, NULL, &geometry) != ELLGRAN_SUCCESS) {
    fprintf(stderr, "%s\n", ellgran_last_error());
    return 1;
  }
  printf("ellgran %s: %d %.3f\n", ellgran_version(), (int) geometry.touching, geometry.penetration);
  return 0;
}
