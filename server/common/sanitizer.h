/* sanitizer.h - SANITIZED: is this a build with AddressSanitizer or ThreadSanitizer? They take
 * terabytes of address space and read /proc, which limits and sandbox would forbid. */
#ifndef SCATTERD_SANITIZER_H
#define SCATTERD_SANITIZER_H

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

#endif
