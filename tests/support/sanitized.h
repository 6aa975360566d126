/* BERTH_SANITIZED is defined where the address sanitizer looks on: gcc says so by a macro, clang by a feature. */
#ifndef TESTS_SUPPORT_SANITIZED_H
#define TESTS_SUPPORT_SANITIZED_H

#ifdef __has_feature
#if __has_feature(address_sanitizer)
#define BERTH_SANITIZED
#endif
#endif
#ifdef __SANITIZE_ADDRESS__
#define BERTH_SANITIZED
#endif

#endif
