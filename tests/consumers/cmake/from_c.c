/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* Overlap of two unit spheres; prints it, and the version of the library. */
#include <ellgran.h>

#include <stdio.h>

int main(void)
{
  EllgranBody i = {sizeof(EllgranBody), {0, 0, 0}, {1, 0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}, 1, 1, 1};
  EllgranBody j = i;
  EllgranContactGeometry geometry = ELLGRAN_INIT(EllgranContactGeometry);
  j.position[0] = 1.5;
  if (ellgran_contact_geometry(NULL, &i, &j, NULL, &geometry) != ELLGRAN_SUCCESS) {
    fprintf(stderr, "%s\n", ellgran_last_error());
    return 1;
  }
  printf("ellgran %s: %d %.3f\n", ellgran_version(), (int) geometry.touching, geometry.penetration);
  return 0;
}
