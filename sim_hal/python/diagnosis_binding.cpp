#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "../../hal/rig/beam.h"
#include "../../hal/rig/units.h"
#include "../diagnosis/diagnosis.h"
#include "../stability/arm_loop.h"
#include "arrays.h"
#include "bindings.h"

namespace nb = nanobind;

namespace berth
{

namespace
{

nb::dict as_dict(const parameter_estimate &parameter)
{
    nb::dict made;
    made["key"] = parameter.key;
    made["value"] = parameter.value;
    made["ci95"] = parameter.ci95;
    made["unit"] = std::string(unit_of(parameter.key));
    return made;
}

nb::dict as_dict(const cause &known)
{
    nb::list parameters;
    for (const parameter_estimate &parameter : known.parameters) {
        parameters.append(as_dict(parameter));
    }
    nb::dict made;
    made["effect"] = nb::cast(std::string(known.effect->name));
    made["parameters"] = parameters;
    made["delta_bic"] = known.delta_bic;
    made["share_explained"] = known.share_explained;
    return made;
}

nb::dict as_dict(block_diagnosis &block)
{
    nb::list causes;
    for (const cause &known : block.causes) {
        causes.append(as_dict(known));
    }
    nb::list alternatives;
    for (const alternative &other : block.alternatives) {
        alternatives.append(nb::cast(std::string(other.effect->name)));
    }
    nb::dict made;
    made["block"] = nb::cast(std::string(block_names[static_cast<int>(block.block)]));
    made["verdict"] = nb::cast(std::string(verdict_names[static_cast<int>(block.verdict)]));
    made["unit"] = nb::cast(std::string(block_units[static_cast<int>(block.block)]));
    made["causes"] = causes;
    made["alternatives"] = alternatives;
    made["rms_before"] = block.held_out_rms.before;
    made["rms_after"] = block.held_out_rms.after;
    made["rms_floor"] = block.held_out_rms.floor;
    made["error_before"] = as_array(std::vector<double>(block.error_before.begin(), block.error_before.end()));
    made["error_after"] = as_array(std::vector<double>(block.error_after.begin(), block.error_after.end()));
    return made;
}

nb::dict as_dict(const record &data)
{
    const std::pair<const char *, const std::vector<double> *> columns[] = {
        {"operator_force_N", &data.operator_force_N},
        {"operator_position_m", &data.operator_position_m},
        {"command_position_m", &data.command_position_m},
        {"robot_position_m", &data.robot_position_m},
        {"force_N", &data.force_N}};
    nb::dict made;
    made["time_s"] = as_array(data.time_s);
    for (const auto &[name, values] : columns) {
        if (!values->empty()) {
            made[name] = as_array(*values);
        }
    }
    return made;
}

/* As `berth diagnose`. */
nb::dict diagnose_records(const std::vector<std::string> &records, const rig_handle &handle,
                          const std::string &validation, const std::string &repetition,
                          const std::string &standstill, std::optional<double> limit_s,
                          const std::vector<std::string> &without)
{
    diagnosis_request request;
    request.records = records;
    request.validation = validation;
    request.repetition = repetition;
    request.standstill = standstill;
    request.limit_s = limit_s;
    request.rig = handle.get();
    for (const std::string &name : without) {
        if (find_effect(name) == nullptr) {
            throw input_error("without: there is no effect called " + name + "; see `berth effects`");
        }
        request.options.without.push_back(name);
    }
    std::optional<diagnosis> found;
    {
        const nb::gil_scoped_release released;
        refuse_arm(request.rig);
        refuse_beam(request.rig);
        found = diagnose(request);
    }
    nb::list blocks;
    for (block_diagnosis &block : found->blocks) {
        blocks.append(as_dict(block));
    }
    nb::dict made;
    made["verdict"] = nb::cast(std::string(verdict_names[static_cast<int>(found->verdict)]));
    made["block"] = found->located.empty() ? nb::none() : nb::cast(found->located);
    made["blocks"] = blocks;
    made["notes"] = nb::cast(found->notes);
    made["not_tried"] = nb::cast(found->not_tried);
    made["period_s"] = found->data.period_s;
    made["signals"] = as_dict(found->data);
    made["given"] = nb::cast(rig_handle(found->given));
    made["extended"] = nb::cast(rig_handle(found->extended));
    return made;
}

} // namespace

void bind_diagnosis(nb::module_ &module)
{
    module.def("diagnose", &diagnose_records, nb::arg("records"), nb::arg("rig"), nb::arg("validation"),
               nb::arg("repetition"), nb::arg("standstill"), nb::arg("limit_s").none(), nb::arg("without"));
}

} // namespace berth
