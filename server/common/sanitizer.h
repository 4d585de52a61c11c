/* sanitizer.h - SANITIZED: is this a build with AddressSanitizer? It takes terabytes of address
 * space and reads /proc, which limits and sandbox would forbid. */
#ifndef SCATTERD_SANITIZER_H
#define SCATTERD_SANITIZER_H

#if defined(__SANITIZE_ADDRESS__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

#endif
