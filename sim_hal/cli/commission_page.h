/* The page of a commissioning: what each stage measured against what the rig file assumes. */
#ifndef SIM_HAL_CLI_COMMISSION_PAGE_H
#define SIM_HAL_CLI_COMMISSION_PAGE_H

#include <string>

#include "../../hal/rig/commissioning.h"

namespace berth
{

/* "dead time 21.0 ms +- 0.1, assumed 17.5 ms" */
std::string words_of(const stage_value &value);

std::string commission_page(const commissioning &record, const std::string &configuration);

} // namespace berth

#endif
