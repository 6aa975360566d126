#include "version.h"

namespace berth
{

const char *version()
{
    return BERTH_COMMIT;
}

} // namespace berth
