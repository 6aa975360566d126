/* Rig files: TOML, every key with its unit in the name. Any error names file, line, key and what to do. */
#ifndef HAL_RIG_RIG_FILE_H
#define HAL_RIG_RIG_FILE_H

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "rig.h"

namespace berth
{

/* What a user got wrong: one line for a person. Ends the program with exit code 2. */
class input_error : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;

    /* "place: key: message", and the parts for a program. `place`: a file, "file:line" or an option. */
    input_error(const std::string &place, const std::string &key, const std::string &message)
        : std::runtime_error(place + ": " + key + ": " + message), place_(place), key_(key)
    {
    }

    /* Empty where the line has none. */
    const std::string &place() const { return place_; }
    const std::string &key() const { return key_; }

  private:
    std::string place_;
    std::string key_;
};

/* A rig, a robot preset or an arm shipped with the program. */
struct shipped_file {
    const char *name;
    const char *text;
};

const std::vector<shipped_file> &shipped_rigs();
const std::vector<shipped_file> &shipped_arms();

struct robot_preset; /* robot_file.h */

/* Loads a shipped rig by name or a file by path, applies the robot preset, if there is one, then `overrides`
 * ("section.key=value"), and checks the result: over the whole range of dead times, if the preset states one. What
 * the preset does not state stays the rig's. Throws input_error. */
rig load_rig(const std::string &name_or_path, const std::vector<std::string> &overrides = {},
             const robot_preset *robot = nullptr);

/* The same from text; `origin` stands for the file's name in messages. */
rig parse_rig(const std::string &text, const std::string &origin, const std::vector<std::string> &overrides = {},
              const robot_preset *robot = nullptr);

bool is_overridden(std::string_view path, const std::vector<std::string> &overrides);

/* The resolved rig as a rig file with every key and what it means; reads back to the same rig. */
std::string print_rig(const rig &rig);

/* The same for a person: each key also says whether it was given or is assumed, and the list `assumed` reads that
 * back.
 */
std::string print_config(const rig &rig);

/* text_hash() of print_rig(): names a configuration. */
std::string config_hash(const rig &rig);

/* FNV-1a, 64 bits, as 16 hexadecimal digits. */
std::string text_hash(std::string_view bytes);

/* All of a file. Throws input_error, also where it is larger: a device has no end. */
std::string read_file(const std::string &path, std::size_t at_most_bytes = std::size_t{64} << 30);

/* A file that a person writes. */
constexpr std::size_t written_bytes_max = std::size_t{64} << 20;

} // namespace berth

#endif
