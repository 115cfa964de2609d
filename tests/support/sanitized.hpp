#pragma once

// VERIDYN_SANITIZED: 1 under the address or the thread sanitizer, which bring a malloc of their own. g++ defines names for
// them, clang answers to __has_feature.

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define VERIDYN_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define VERIDYN_SANITIZED 1
#endif
#endif
#ifndef VERIDYN_SANITIZED
#define VERIDYN_SANITIZED 0
#endif
