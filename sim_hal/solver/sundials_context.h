/* A context of SUNDIALS, which prints no errors, as its callers report them: version 7 has another type for no
 * communicator, and takes error handlers by context rather than by solver. */
#ifndef SIM_HAL_SOLVER_SUNDIALS_CONTEXT_H
#define SIM_HAL_SOLVER_SUNDIALS_CONTEXT_H

#include <cvode/cvode.h>
#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>

namespace berth
{

/* Both return what SUNDIALS returns: negative, it has failed. */
inline int create_context(SUNContext *context)
{
#if SUNDIALS_VERSION_MAJOR >= 7
    const int flag = SUNContext_Create(SUN_COMM_NULL, context);
    return flag < 0 ? flag : SUNContext_ClearErrHandlers(*context);
#else
    return SUNContext_Create(nullptr, context);
#endif
}

inline int keep_quiet([[maybe_unused]] void *cvode_memory)
{
#if SUNDIALS_VERSION_MAJOR >= 7
    return 0; /* its context has no error handlers */
#else
    return CVodeSetErrFile(cvode_memory, nullptr);
#endif
}

} // namespace berth

#endif
