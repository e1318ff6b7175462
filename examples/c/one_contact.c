/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/*
 * The force of one contact: two ellipsoids that overlap by 10 micrometres and approach.
 *
 *   cc one_contact.c $(pkg-config --cflags --libs ellgran)
 *
 * Prints: normal force 10.5319 mN
 */
#include <ellgran.h>
#include <stdio.h>

int main(void)
{
  const char *words[] = {"nfd", "1e7", "0.3", "200", "200", "tangential", "tfd", "0.5"};
  /* every struct begins with its size, which ELLGRAN_INIT sets */
  EllgranLawParameters parameters = ELLGRAN_INIT(EllgranLawParameters);
  EllgranLaws *laws = NULL;
  uint8_t is_set = 1;
  if (ellgran_law_parameters_parse(8, words, NULL, &parameters) ||
      ellgran_laws_new(1, &parameters, &is_set, 0, &laws)) {
    fprintf(stderr, "%s\n", ellgran_last_error());
    return 1;
  }
  EllgranBody i = ELLGRAN_INIT(EllgranBody);
  i.quaternion[0] = 1;
  i.semi_axes[0] = 2e-3;
  i.semi_axes[1] = i.semi_axes[2] = 1e-3;
  i.mass = 1e-5;
  i.particle_type = 1;
  EllgranBody j = i;
  j.position[2] = 1.99e-3;
  j.velocity[2] = -0.1;
  EllgranStep step = ELLGRAN_INIT(EllgranStep);
  step.time_step = 1e-6;
  step.advance_history = 1;
  int32_t touching = 0;
  double history[8] = {0}; /* ellgran_laws_history_length(laws) doubles per contact, zero at first */
  EllgranContactForce force = ELLGRAN_INIT(EllgranContactForce);
  if (ellgran_contact(laws, &i, &j, &step, &touching, history, NULL, &force)) {
    fprintf(stderr, "%s\n", ellgran_last_error());
    return 1;
  }
  printf("normal force %.6g mN\n", 1e3 * force.normal_force);
  ellgran_laws_free(laws);
  return 0;
}
