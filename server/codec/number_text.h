/* number_text.h - doubles as text and back, correctly rounded, independent of the locale. */
#ifndef SCATTERD_NUMBER_TEXT_H
#define SCATTERD_NUMBER_TEXT_H

#ifdef __cplusplus
extern "C" {
#endif

enum { NUMBER_TEXT_MAX = 32 }; /* bytes number_print may write */

/* Reads the JSON number (RFC 8259, section 6) at first: *value = the nearest double, infinite if
 * too large. Returns where it ends, NULL if no number stands there. Linear in its length; about
 * 25 ns for 17 digits. */
const char *number_parse(const char *first, const char *last, double *value);

/* Writes the shortest text that reads back as the same finite double, no NUL; integers up to 2^53
 * without fraction or exponent. Returns the end. */
char *number_print(char *to, double value);

/* Writes a decimal integer, no NUL. Returns the end. */
char *number_print_integer(char *to, long long value);

#ifdef __cplusplus
}
#endif

#endif
