#include <charconv>
#include <sstream>

#include "arm_file.h"
#include "arm_keys.h"
#include "keys.h"
#include "toml_file.h"

namespace berth
{

namespace
{

std::string numbers_text(const double *values, std::size_t count)
{
    if (count == 1) {
        return number_text(*values);
    }
    std::string text = "[";
    for (std::size_t i = 0; i < count; i++) {
        text += (i == 0 ? "" : ", ") + number_text(values[i]);
    }
    return text + "]";
}

void print_line(std::ostream &text, const std::string &line, std::string_view meaning)
{
    std::string padded = line;
    if (!meaning.empty()) {
        padded.resize(std::max<std::size_t>(padded.size(), 50), ' ');
        padded += " # " + std::string(meaning);
    }
    text << padded << "\n";
}

template <class Keys>
void print_numbers(std::ostream &text, const Keys &keys, const void *object)
{
    for (const number_key &key : keys) {
        const auto *const values = reinterpret_cast<const double *>(static_cast<const char *>(object) + key.offset);
        print_line(text, std::string(key.name) + " = " + numbers_text(values, key.count), key.meaning);
    }
}

} // namespace

std::string print_arm(const arm_description &arm, const std::string &section)
{
    const std::string in = section.empty() ? "" : section + ".";
    const arm_config &config = arm.config;
    const bool is_planar = config.kind == ARM_PLANAR;
    std::ostringstream text;
    if (!section.empty()) {
        text << "[" << section << "]\n";
    }
    text << "name = " << in_quotes(arm.name) << "\ndescription = " << in_quotes(arm.description) << "\n";
    text << "kind = \"" << kind_words[static_cast<std::size_t>(config.kind)] << "\"\n";
    text << "integrator = \"" << integrator_words[static_cast<std::size_t>(config.integrator)] << "\"\n";
    text << "force = \"" << force_words[static_cast<std::size_t>(config.force)] << "\"\n";
    text << "substeps = " << config.substeps << "\n\n[" << in << "base]\n";
    text << "is_free = " << (config.base_is_free != 0 ? "true" : "false") << "\n";
    print_line(text, "position_m = " + numbers_text(config.base_position_m, 3), "in the world, at the start");
    print_line(text,
               is_planar ? "turn_rad = " + number_text(config.base_attitude[0])
                         : "quaternion = " + numbers_text(config.base_attitude, 4),
               is_planar ? "" : "w, x, y, z");
    print_line(text, "gravity_m_per_s2 = " + numbers_text(config.gravity_m_per_s2, 3), "in the world");
    print_numbers(text, body_keys, &config.base);
    for (std::int64_t i = 0; i < config.joint_count; i++) {
        const arm_joint &joint = config.joints[i];
        text << "\n[[" << in << "joint]]\nname = " << in_quotes(arm.joint_names[static_cast<std::size_t>(i)])
             << "\n";
        print_numbers(text, frame_keys, &joint.frame);
        print_numbers(text, joint_keys, &joint);
        text << "[" << in << "joint.link]\n";
        print_numbers(text, body_keys, &joint.link);
    }
    text << "\n[" << in << "tool]\n";
    print_numbers(text, frame_keys, &config.tool);
    text << "\n[" << in << "payload]\n";
    print_numbers(text, body_keys, &config.payload);
    text << "\n[" << in << "attitude]\nactuator = \""
         << actuator_words[static_cast<std::size_t>(config.attitude.actuator)]
         << "\"\nperiod_ticks = " << config.attitude.period_ticks << "\n";
    print_numbers(text, attitude_keys, &config.attitude);
    return text.str();
}

} // namespace berth
