#include "names.h"

#include <algorithm>
#include <cctype>

#include "keys.h"

namespace berth
{

namespace
{

/* As names are compared: in small letters, a line as a dash. */
std::string in_one_spelling(std::string_view word)
{
    std::string small(word);
    std::transform(small.begin(), small.end(), small.begin(),
                   [](unsigned char c) { return c == '_' ? '-' : static_cast<char>(std::tolower(c)); });
    return small;
}

/* The same but for two neighbours that changed places: one slip of the fingers. */
bool is_swapped(std::string_view word, std::string_view name)
{
    if (word.size() != name.size()) {
        return false;
    }
    const auto first = std::mismatch(word.begin(), word.end(), name.begin());
    const auto at = static_cast<std::size_t>(first.first - word.begin());
    return at + 1 < word.size() && word[at] == name[at + 1] && word[at + 1] == name[at] &&
           word.substr(at + 2) == name.substr(at + 2);
}

/* Between words in one spelling. A beginning is nearer than a part, a part nearer than a slip. */
double distance_between(const std::string &word, const std::string &name)
{
    if (word == name) {
        return 0.0;
    }
    if (name.compare(0, word.size(), word) == 0) {
        return 0.4 / static_cast<double>(1 + word.size()); /* the longer, the nearer */
    }
    constexpr std::size_t shortest_beginning = 4; /* eigen of eigenvalues */
    if (name.size() >= shortest_beginning && word.compare(0, name.size(), name) == 0) {
        return 0.5;
    }
    constexpr std::size_t shortest_part = 3;
    if (word.size() >= shortest_part && name.find(word) != std::string::npos) {
        return 0.5;
    }
    return is_swapped(word, name) ? 1.0 : static_cast<double>(edit_distance(word, name));
}

} // namespace

std::string nearest_name(const std::vector<std::string> &names, std::string_view word)
{
    const std::string wanted = in_one_spelling(word);
    const auto to_wanted = [&](const std::string &name) { return distance_between(wanted, in_one_spelling(name)); };
    const auto nearest = std::min_element(names.begin(), names.end(),
                                          [&](const auto &a, const auto &b) { return to_wanted(a) < to_wanted(b); });
    return nearest == names.end() ? "" : *nearest;
}

std::string near_name(const std::vector<std::string> &names, std::string_view word)
{
    const std::string nearest = nearest_name(names, word);
    const double shortest = nearest.size() > 3 ? 2.0 : 1.0; /* of three letters, two others are another word */
    const double slips = std::max(shortest, static_cast<double>(nearest.size()) / 3.0);
    return distance_between(in_one_spelling(word), in_one_spelling(nearest)) <= slips ? nearest : "";
}

std::string did_you_mean(const std::vector<std::string> &names, std::string_view word)
{
    const std::string near = near_name(names, word);
    return near.empty() ? "" : "; did you mean " + near + "?";
}

/* "[loop] has rate_Hz, phase_ms; "; of a section that has many, or none: nothing. */
static std::string keys_of_section(std::string_view section)
{
    constexpr std::size_t listed_max = 8;
    std::string names;
    std::size_t count = 0;
    for (const rig_key &key : rig_keys()) {
        if (key.path.substr(0, key.path.find('.')) == section) {
            names += (count++ > 0 ? ", " : "") + std::string(key.path.substr(section.size() + 1));
        }
    }
    return count > 0 && count <= listed_max ? "[" + std::string(section) + "] has " + names + "; " : "";
}

std::string unknown_key_words(std::string_view path)
{
    const std::string_view nearest = nearest_key(path);
    const std::size_t dot = path.rfind('.');
    const bool has_section = dot != std::string_view::npos;
    const bool is_same_section = has_section && nearest.substr(0, dot + 1) == path.substr(0, dot + 1);
    const std::string_view known =
        has_section && !is_same_section ? nearest : nearest.substr(nearest.rfind('.') + 1);
    const std::string_view wanted = is_same_section ? path.substr(dot + 1) : path;
    const bool is_beginning = known.substr(0, wanted.size()) == wanted;
    const std::size_t far_off = std::min(known.size(), wanted.size()) / 2 + 1;
    return is_beginning || key_distance(wanted, known) < far_off
               ? "unknown key; the nearest known one is " + std::string(nearest)
               : "unknown key, and none is near; " + keys_of_section(path.substr(0, path.find('.'))) +
                     "`berth schema` lists all";
}

} // namespace berth
