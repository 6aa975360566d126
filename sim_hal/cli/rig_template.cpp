#include "rig_template.h"

#include <algorithm>
#include <sstream>
#include <string_view>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "../../hal/rig/sections.h"
#include "../effects/effect.h"
#include "../margin.h"
#include "../prediction.h"
#include "../verdict_words.h"
#include "rig_schema.h"

namespace berth
{

namespace
{

struct setting {
    std::string_view path;
    std::string_view text;
};

struct named_part {
    std::string_view name;
    std::string_view remark; /* where the values come from */
    std::vector<setting> settings;
};

/* As the shipped rigs have them: ess, concept-foam, ess-beam. */
const std::vector<named_part> object_parts = {
    {"gripped",
     "a gripped mass on a spring, as the solar generator of the rig ess: 0.77 Hz by itself",
     {{"run.duration_s", "20.0"},
      {"manipulator.initial_position_m", "0.01"},
      {"object.kind", "gripped"},
      {"object.mass_kg", "100.0"},
      {"object.stiffness_N_per_m", "2370.0"},
      {"object.damping_N_s_per_m", "19.5"}}},
    {"contact",
     "a tool that pushes on rubber foam, as in the rig concept-foam",
     {{"run.duration_s", "20.0"},
      {"manipulator.initial_position_m", "-0.02"},
      {"operator.interface", "motion"},
      {"profile.kind", "minimum_jerk"},
      {"profile.offset_m", "-0.02"},
      {"profile.amplitude_m", "0.04"},
      {"profile.duration_s", "2.0"},
      {"object.kind", "contact"},
      {"object.mass_kg", "1.0"},
      {"object.stiffness_N_per_m", "2000.0"},
      {"object.damping_N_s_per_m", "150.0"},
      {"object.surface_position_m", "0.0"}}},
    {"beam",
     "a clamped beam of three modes, the first at 0.25 Hz",
     {{"run.duration_s", "20.0"},
      {"manipulator.initial_position_m", "0.001"},
      {"object.kind", "beam"},
      {"object.modes", "3"},
      {"object.beam_length_m", "8.0"},
      {"object.beam_mass_kg_per_m", "50.0"},
      {"object.beam_stiffness_N_m2", "40000.0"},
      {"object.beam_damping_ratio", "0.05"}}},
    {"none",
     "nothing: the robot moves freely",
     {{"run.duration_s", "20.0"}, {"manipulator.initial_position_m", "0.01"}, {"object.kind", "none"}}},
};

const std::vector<named_part> sensor_parts = {
    {"one-axis",
     "one frame per sample, a stiff sensor and a low-pass of 20 Hz, as in the rig ess",
     {{"sensor_channel.layout", "one_frame"},
      {"sensor_channel.force_limit_N", "20000.0"},
      {"sensor.stiffness_N_per_m", "2e7"},
      {"sensor.low_pass_order", "2"},
      {"sensor.low_pass_frequency_Hz", "20.0"},
      {"sensor.low_pass_damping_ratio", "0.7"}}},
    {"six-axis",
     "forces and torques in two frames; the loop moves along x",
     {{"sensor_channel.layout", "two_frames_intel"},
      {"sensor_channel.axis", "x"},
      {"sensor_channel.force_limit_N", "300.0"},
      {"sensor.stiffness_N_per_m", "2e7"},
      {"sensor.low_pass_order", "2"},
      {"sensor.low_pass_frequency_Hz", "20.0"},
      {"sensor.low_pass_damping_ratio", "0.7"}}},
    {"unfiltered",
     "one frame per sample without a low-pass, and noise of 0.5 N",
     {{"sensor_channel.layout", "one_frame"},
      {"sensor_channel.force_limit_N", "20000.0"},
      {"sensor.stiffness_N_per_m", "2e7"},
      {"sensor.low_pass_order", "0"},
      {"sensor.noise_N", "0.5"}}},
};

const std::vector<setting> common_settings = {
    {"run.release_s", "0.1"},
    {"run.seed", "1"},
    {"loop.rate_Hz", "400.0"},
    {"manipulator.mass_kg", "200.0"},
    {"manipulator.stiffness_N_per_m", "7900.0"},
    {"manipulator.damping_N_s_per_m", "125.0"},
    {"limits.position_min_m", "-1.0"},
    {"limits.position_max_m", "1.0"},
    {"limits.velocity_m_per_s", "2.0"},
    {"limits.acceleration_m_per_s2", "50.0"},
    {"robot.dead_time_ms", "17.5"},
    {"robot.interpolation", "linear"},
    {"sensor.damping_ratio", "0.05"},
    {"sensor.delay_ms", "2.5"},
};

/* What grows with the object's size: scaled together, its frequency and damping ratio stay. */
constexpr std::string_view keys_of_size[] = {"object.mass_kg", "object.stiffness_N_per_m",
                                             "object.damping_N_s_per_m", "object.beam_mass_kg_per_m",
                                             "object.beam_stiffness_N_m2"};

/* A rig as it is written: the object is made smaller until the loop is stable with this share of its dead time to
 * spare. */
struct sized_rig {
    berth::rig rig;
    double object_share;
    std::string flaw_of_whole; /* "grows by +61.7 /s"; empty: there is none */
};
constexpr double spare_share = 0.1;

bool has_margin(const rig &rig)
{
    if (is_stable(predict_growth(rig)) != std::optional<bool>(true)) {
        return false;
    }
    const stability_margin margin = margin_of(rig);
    return margin.is_unlimited || margin.dead_time_ms.value_or(0.0) > spare_share * rig.robot.dead_time_ms;
}

sized_rig sized_to_be_stable(const rig &whole)
{
    constexpr double shares[] = {1.0, 0.5, 0.25, 0.1, 0.05, 0.025, 0.01, 0.005, 0.0025};
    sized_rig made{whole, 1.0, ""};
    for (const double share : shares) {
        made.object_share = share;
        made.rig = whole;
        for (const std::string_view key : keys_of_size) {
            set_number(made.rig, key, share * value_of(whole, key));
        }
        if (!complete_and_check(made.rig) && has_margin(made.rig)) {
            break;
        }
        if (share == 1.0) {
            const double growth_per_s = predict_growth(whole).growth_per_s.value_or(0.0);
            made.flaw_of_whole = growth_per_s > 0.0 ? with_numbers("grows by %+.3g /s", growth_per_s)
                                                    : with_numbers("has less than %.0f %% of its dead time to spare",
                                                                   100.0 * spare_share);
        }
    }
    return made;
}

std::string size_remark(const sized_rig &made)
{
    if (made.object_share == 1.0) {
        return "";
    }
    return with_numbers(
               ". Scaled to %.3g of that, with the same frequency and damping ratio: with this robot's dead "
               "time and this sensor, the loop with the whole of it ",
               made.object_share) +
           made.flaw_of_whole;
}

std::vector<std::string> part_names(const std::vector<named_part> &parts)
{
    std::vector<std::string> names;
    names.reserve(parts.size());
    for (const named_part &part : parts) {
        names.emplace_back(part.name);
    }
    return names;
}

const named_part &part_of(const std::vector<named_part> &parts, const std::string &name)
{
    return *std::find_if(parts.begin(), parts.end(), [&](const named_part &part) { return part.name == name; });
}

/* A file without comments, which gives the values their checks and the robot preset its place. */
std::string plain_text(const std::vector<setting> &settings)
{
    std::string text;
    for (const setting &one : settings) {
        const bool is_word = find_key(one.path)->type == key_type::choice;
        text.append(one.path).append(" = ");
        text += (is_word ? in_quotes(one.text) : std::string(one.text)) + "\n";
    }
    return text;
}

std::string_view section_meaning_of(std::string_view name)
{
    for (const section_meaning &section : section_meanings()) {
        if (section.name == name) {
            return section.meaning;
        }
    }
    return "";
}

/* Whether the key's meaning names each of its words; a key that is no choice has none. */
bool explains_choices(const rig_key &key)
{
    return std::all_of(key.choices.begin(), key.choices.end(),
                       [&](std::string_view choice) { return key.meaning.find(choice) != std::string_view::npos; });
}

/* Comments of at most 100 letters a line. */
void write_remark(std::ostream &text, const std::string &remark)
{
    std::istringstream words(remark);
    std::string line = "#";
    for (std::string word; words >> word; line += " " + word) {
        if (line.size() + word.size() > 100) {
            text << line << "\n";
            line = "#";
        }
    }
    text << line << "\n";
}

} // namespace

std::vector<std::string> template_objects()
{
    return part_names(object_parts);
}

std::vector<std::string> template_sensors()
{
    return part_names(sensor_parts);
}

std::string rig_template(const template_choice &choice)
{
    const named_part &object = part_of(object_parts, choice.object);
    const named_part &sensor = part_of(sensor_parts, choice.sensor);
    std::vector<setting> settings = common_settings;
    settings.insert(settings.end(), object.settings.begin(), object.settings.end());
    settings.insert(settings.end(), sensor.settings.begin(), sensor.settings.end());
    const robot_preset *const robot = choice.robot ? &*choice.robot : nullptr;
    const sized_rig sized =
        sized_to_be_stable(parse_rig(plain_text(settings), "the rig that berth init writes", {}, robot));
    const rig &rig = sized.rig;

    std::vector<std::string_view> paths;
    paths.reserve(settings.size() + (robot != nullptr ? robot->settings.size() : 0));
    for (const setting &one : settings) {
        paths.push_back(one.path);
    }
    for (std::size_t i = 0; robot != nullptr && i < robot->settings.size(); i++) {
        paths.push_back(robot->settings[i].path);
    }
    std::ostringstream text;
    text << "#:schema ./" << rig_schema_file << "\n";
    text << "# Rig file of berth, made by `berth init`. Put in the values of your hardware, then ask\n"
            "#   berth check FILE    implausible values, delay budget, verdict\n"
            "#   berth run FILE      run the loop against the simulated rig\n"
            "# Before a robot is switched on: [limits] and sensor_channel.force_limit_N are wide here. Set them to "
            "what "
            "your\n"
            "# robot, its payload and your sensor withstand.\n"
            "# The schema in the first line tells editors (taplo, Even Better TOML) every key, its unit and its "
            "range.\n"
            "name = "
         << in_quotes(choice.name) << "\ndescription = "
         << in_quotes("Robot " + (robot ? robot->name : "of the rig ess") + ", sensor " + choice.sensor +
                      ", object " + choice.object)
         << "\n";
    std::string section;
    for (const rig_key &key : rig_keys()) {
        if (std::find(paths.begin(), paths.end(), key.path) == paths.end()) {
            continue;
        }
        const std::size_t dot = key.path.find('.');
        if (key.path.substr(0, dot) != section) {
            section = key.path.substr(0, dot);
            text << "\n";
            write_remark(text, section == "robot" && robot ? robot->source + " " + robot->assumed
                               : section == "sensor"       ? std::string(sensor.remark)
                               : section == "object"       ? std::string(object.remark) + size_remark(sized)
                                                           : std::string(section_meaning_of(section)));
            text << "[" << section << "]\n";
        }
        std::string line = std::string(key.path.substr(dot + 1)) + " = " + value_text(rig, key);
        line.resize(std::max<std::size_t>(line.size(), 42), ' ');
        text << line << " # " << key.meaning;
        for (std::size_t i = 0; !explains_choices(key) && i < key.choices.size(); i++) {
            text << (i == 0 ? ": " : ", ") << key.choices[i];
        }
        text << "\n";
    }
    return text.str();
}

} // namespace berth
