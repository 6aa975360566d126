/* Which program this is. */
#ifndef HAL_VERSION_H
#define HAL_VERSION_H

namespace berth
{

/* Semantic version. */
constexpr const char *release = "1.0.0-rc.1";

/* The commit that this program was built from, "-dirty" if there were changes, or "unknown". */
const char *version();

} // namespace berth

#endif
