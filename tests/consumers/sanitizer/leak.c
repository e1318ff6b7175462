/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* Builds laws and never frees them: a leak check that lets this pass does not see what the library allocates. */
#include <ellgran.h>

#include <stddef.h>

int main(void)
{
  static const char *const words[] = {"hertz", "1e7", "0.3"};
  EllgranLawParameters parameters = ELLGRAN_INIT(EllgranLawParameters);
  EllgranLaws *laws = NULL;
  const uint8_t is_set = 1;
  if (ellgran_law_parameters_parse(3, words, NULL, &parameters) != ELLGRAN_SUCCESS) return 2;
  if (ellgran_laws_new(1, &parameters, &is_set, 0, &laws) != ELLGRAN_SUCCESS) return 2;
  laws = NULL;
  return 0;
}
