/* The Python module berth._core: the host library (berth.h) as nanobind classes. What is nicer in Python is written
 * in Python, in berth/. */
#ifndef SIM_HAL_PYTHON_BINDINGS_H
#define SIM_HAL_PYTHON_BINDINGS_H

#include <nanobind/nanobind.h>
#include <optional>
#include <string>
#include <vector>

#include "../../hal/rig/rig_file.h"

namespace berth
{

/* A rig file with settings on top, as `--set` puts them there: read anew after each change, so that it is the rig
 * that the command would have. */
class rig_handle
{
  public:
    /* A shipped rig by name or a file by path, which is read once; `robot`: a preset, may be empty. */
    static rig_handle load(const std::string &name_or_path, const std::vector<std::string> &settings,
                           const std::string &robot);
    static rig_handle parse(const std::string &text, const std::string &origin,
                            const std::vector<std::string> &settings, const std::string &robot);

    /* One that is a rig already, such as an extended one. */
    explicit rig_handle(berth::rig resolved);

    /* "section.key=value", in place of an earlier one of the same key. Throws input_error and stays as it was. */
    void set(const std::string &setting);
    const berth::rig &get() const { return resolved_; }

    /* To work on without Python's lock: another thread may change this one meanwhile. */
    berth::rig snapshot() const { return resolved_; }
    const std::vector<std::string> &settings() const { return settings_; }
    const std::string &origin() const { return origin_; }

  private:
    rig_handle(std::string text, std::string origin, std::string name, std::vector<std::string> settings,
               std::string robot);
    berth::rig resolve(const std::vector<std::string> &settings) const;

    std::string text_;
    std::string origin_;
    std::string name_; /* of a file that states none */
    std::vector<std::string> settings_;
    std::string robot_;
    berth::rig resolved_;
};

void bind_rig(nanobind::module_ &module);
void bind_answers(nanobind::module_ &module);
void bind_runs(nanobind::module_ &module);
void bind_diagnosis(nanobind::module_ &module);

} // namespace berth

#endif
