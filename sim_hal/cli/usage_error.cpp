#include "usage_error.h"

#include <algorithm>
#include <cctype>

#include "../../hal/rig/keys.h"

namespace berth
{

namespace
{

std::vector<std::string> names_of_subcommands(const CLI::App &app)
{
    std::vector<std::string> names;
    for (const CLI::App *const known : app.get_subcommands(nullptr)) {
        names.push_back(known->get_name());
    }
    return names;
}

bool is_one_of(const std::vector<std::string> &names, const std::string &name)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

/* Empty: none is near. What begins with a name, or is its beginning, is nearer than all else. */
std::string nearest_subcommand(const std::vector<std::string> &names, std::string word)
{
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto to_word = [&](const std::string &name) {
        const std::size_t shared = std::min(name.size(), word.size());
        return name.compare(0, shared, word, 0, shared) == 0 ? 0 : edit_distance(word, name);
    };
    constexpr std::size_t slips = 2;
    const auto nearest = std::min_element(names.begin(), names.end(),
                                          [&](const auto &a, const auto &b) { return to_word(a) < to_word(b); });
    return to_word(*nearest) <= slips ? *nearest : "";
}

std::string no_subcommand(const std::vector<std::string> &names, const std::vector<std::string> &words)
{
    std::string message = words[0] + ": no such subcommand; ";
    if (words.size() > 1 && is_one_of(names, words[1])) {
        message += "it stands first: berth " + words[1] + " " + words[0] + "; ";
    } else if (const std::string nearest = nearest_subcommand(names, words[0]); !nearest.empty()) {
        message += "did you mean " + nearest + "? ";
    }
    message += "there are";
    for (const std::string &name : names) {
        message += (name == names.front() ? " " : ", ") + name;
    }
    return message;
}

/* A setting of the rig as people write it; empty: all are as they must be. */
std::string wrong_setting(const std::vector<std::string> &words)
{
    for (std::size_t i = 1; i < words.size(); i++) {
        const std::string &word = words[i];
        const std::size_t name_at = word.find_first_not_of('-');
        const std::size_t equals = word.find('=');
        const bool is_set = words[i - 1] == "--set";
        const bool has_blank =
            is_set && equals == std::string::npos && i + 1 < words.size() && words[i + 1][0] != '-';
        if (has_blank) {
            return "--set " + word + " " + words[i + 1] + ": must look like section.key=value, without blanks";
        }
        if (is_set || equals == std::string::npos || name_at == std::string::npos) {
            continue;
        }
        const std::string key = word.substr(name_at, equals - name_at);
        if (key.find('.') != std::string::npos && find_key(key) != nullptr) {
            return word + ": is a key of the rig; write --set " + word.substr(name_at);
        }
    }
    return "";
}

} // namespace

std::string usage_error(const CLI::App &app, const CLI::ParseError &error, const std::vector<std::string> &words)
{
    const std::vector<std::string> names = names_of_subcommands(app);
    if (words.empty()) {
        return error.what();
    }
    const std::string &first = words[0];
    if (first[0] == '-') {
        const auto subcommand =
            std::find_if(words.begin(), words.end(), [&](const auto &word) { return is_one_of(names, word); });
        return subcommand == words.end()
                   ? error.what()
                   : first + ": options stand behind the subcommand, as berth " + *subcommand + " ... " + first;
    }
    if (!is_one_of(names, first)) {
        return no_subcommand(names, words);
    }
    const std::string setting = wrong_setting(words);
    return setting.empty() ? error.what() : setting;
}

} // namespace berth
