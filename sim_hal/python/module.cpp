#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "../../hal/version.h"
#include "bindings.h"

namespace nb = nanobind;

namespace berth
{

namespace
{

/* Of berth/errors.py, which hands it over: a person reads what went wrong, a program its parts. */
PyObject *input_error_type = nullptr;

/* InputError("the line", place, key); the parts are empty where the line has none. */
void raise_input_error(const std::exception_ptr &thrown, void * /*unused*/)
{
    try {
        std::rethrow_exception(thrown);
    } catch (const input_error &error) {
        PyObject *const type = input_error_type != nullptr ? input_error_type : PyExc_ValueError;
        const nb::object made = nb::handle(type)(error.what(), error.place(), error.key());
        PyErr_SetObject(type, made.ptr());
    }
}

} // namespace

} // namespace berth

NB_MODULE(_core, module)
{
    module.doc() = "The host library of berth; use the package `berth`, which is made of it.";
    module.attr("__version__") = berth::version();
    nb::register_exception_translator(berth::raise_input_error, nullptr);
    module.def(
        "raise_as", [](const nb::object &type) { berth::input_error_type = nb::object(type).release().ptr(); },
        nb::arg("type"));
    berth::bind_rig(module);
    berth::bind_answers(module);
    berth::bind_runs(module);
    berth::bind_diagnosis(module);
}
