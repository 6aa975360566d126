/* The commit that this program was built from, "-dirty" if there were changes, or "unknown". */
#ifndef SIM_HAL_VERSION_H
#define SIM_HAL_VERSION_H

namespace berth
{

const char *version();

}

#endif
