/* Which known name somebody meant. */
#ifndef HAL_RIG_NAMES_H
#define HAL_RIG_NAMES_H

#include <string>
#include <string_view>
#include <vector>

namespace berth
{

/* The name most like `word`, by edit distance, whatever the size of its letters, and with '_' as '-'. What begins
 * with the word, or ends or is a part of it, is nearest of all. Empty: there are no names. */
std::string nearest_name(const std::vector<std::string> &names, std::string_view word);

/* The same, or nothing where more than a third of the letters differ. */
std::string near_name(const std::vector<std::string> &names, std::string_view word);

/* "; did you mean ess?" or nothing. */
std::string did_you_mean(const std::vector<std::string> &names, std::string_view word);

/* Of a rig: "unknown key; the nearest known one is ...", or where all are far off, what lists them. A bare name is
 * compared with names. */
std::string unknown_key_words(std::string_view path);

/* Of shipped files. */
template <class Files>
std::vector<std::string> names_of_files(const Files &files)
{
    std::vector<std::string> names;
    names.reserve(std::size(files));
    for (const auto &file : files) {
        names.emplace_back(file.name);
    }
    return names;
}

} // namespace berth

#endif
