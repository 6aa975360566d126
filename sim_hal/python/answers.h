/* Answers as dictionaries with the names of the command's JSON. */
#ifndef SIM_HAL_PYTHON_ANSWERS_H
#define SIM_HAL_PYTHON_ANSWERS_H

#include <nanobind/nanobind.h>

#include "../berth.h"

namespace berth
{

nanobind::dict as_dict(const stability_verdict &verdict, const stability_margin &margin,
                       const growth_prediction &predicted);

} // namespace berth

#endif
