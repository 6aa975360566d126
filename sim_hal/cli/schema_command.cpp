#include <cstdio>

#include "commands.h"
#include "rig_schema.h"

namespace berth
{

int schema_command()
{
    std::fputs(rig_schema_text().c_str(), stdout);
    return 0;
}

} // namespace berth
