/* Half and whole turns, of C++ sources. */
#ifndef FIRMWARE_PI_H
#define FIRMWARE_PI_H

namespace berth
{

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double two_pi = 6.28318530717958647692;

} // namespace berth

#endif
