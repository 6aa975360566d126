/* The commit that this program was built from, "-dirty" if there were changes, or "unknown". */
#ifndef HAL_VERSION_H
#define HAL_VERSION_H

namespace berth
{

const char *version();

}

#endif
