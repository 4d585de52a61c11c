// The one C++ file of the worker: C has no fast, locale-free, correctly rounded conversion.
#include "number_text.h"

#include <charconv>
#include <cmath>
#include <limits>

namespace {

bool is_digit(const char *p, const char *last) {
  return p != last && *p >= '0' && *p <= '9';
}

// What std::from_chars takes and JSON does not: 01, 1., .5, inf, nan, hexadecimal. Looks at the
// integer part and the character behind the point only, because from_chars checks the rest.
bool is_json_number(const char *p, const char *last) {
  if (p != last && *p == '-') p++;
  if (!is_digit(p, last)) return false;
  const bool zero = *p++ == '0';
  if (zero && is_digit(p, last)) return false;
  while (is_digit(p, last)) p++;
  return p == last || *p != '.' || is_digit(p + 1, last);
}

// Is a number known to be out of range too large, not too small? Its decimal exponent tells: that
// of the first digit that is not zero, plus the written one (which itself may be out of range).
bool is_huge(const char *p, const char *last) {
  long long place = 0;
  bool point = false, found = false;
  if (*p == '-') p++;
  for (; p != last && *p != 'e' && *p != 'E'; p++) {
    if (*p == '.') {
      point = true;
    } else if (!found && *p == '0') {
      place -= point ? 1 : 0;
    } else {
      found = true;
      place += point ? 0 : 1;
    }
  }
  if (p == last) return place > 0;
  p += p[1] == '+' ? 2 : 1;
  long long written = 0;
  if (std::from_chars(p, last, written).ec != std::errc()) return *p != '-';
  return written > -place;
}

}  // namespace

const char *number_parse(const char *first, const char *last, double *value) {
  if (!is_json_number(first, last)) return nullptr;
  const auto result = std::from_chars(first, last, *value);
  if (result.ec == std::errc::result_out_of_range) {
    const double limit = is_huge(first, result.ptr) ? std::numeric_limits<double>::infinity() : 0.0;
    *value = *first == '-' ? -limit : limit;
  }
  return result.ptr;
}

char *number_print(char *to, double value) {
  constexpr double exact = 9007199254740992.0;  // 2^53
  if (value >= -exact && value <= exact) {
    const long long integer = static_cast<long long>(value);
    if (static_cast<double>(integer) == value && !(integer == 0 && std::signbit(value))) {
      return number_print_integer(to, integer);
    }
  }
  return std::to_chars(to, to + NUMBER_TEXT_MAX, value).ptr;
}

char *number_print_integer(char *to, long long value) {
  return std::to_chars(to, to + NUMBER_TEXT_MAX, value).ptr;
}
