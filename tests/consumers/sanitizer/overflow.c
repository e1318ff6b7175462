/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* Reads past the end of an allocation: a sanitizer that lets this pass is not on. */
#include <stdlib.h>

int main(int count, char **words)
{
  /* volatile: what it points to is then not known before the program runs */
  char *volatile bytes = calloc(4, 1);
  (void) words;
  return bytes == NULL ? 0 : bytes[count + 3];
}
