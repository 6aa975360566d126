#include "completion.h"

#include <algorithm>
#include <map>
#include <sstream>

namespace berth
{

namespace
{

std::string joined_words(const std::vector<std::string> &words, const char *between = " ")
{
    std::string text;
    for (const std::string &word : words) {
        text += (text.empty() ? "" : between) + word;
    }
    return text;
}

/* In single quotes, as all three shells read it. */
std::string quoted_for_shell(std::string text, const char *quote)
{
    for (std::size_t at = 0; (at = text.find('\'', at)) != std::string::npos; at += std::string_view(quote).size()) {
        text.replace(at, 1, quote);
    }
    return "'" + text + "'";
}

std::vector<std::string> option_names(const command_entry &command)
{
    std::vector<std::string> names;
    for (const option_entry &option : command.options) {
        if (!option.is_positional()) {
            names.push_back(option.name);
        }
    }
    return names;
}

/* What the first positional argument may be. */
std::vector<std::string> first_words(const command_entry &command)
{
    const auto found = std::find_if(command.options.begin(), command.options.end(),
                                    [](const option_entry &option) { return option.is_positional(); });
    return found == command.options.end() ? std::vector<std::string>() : found->words;
}

/* Whether a word behind the command may be a file. */
bool takes_files(const command_entry &command)
{
    return std::any_of(command.options.begin(), command.options.end(),
                       [](const option_entry &option) { return option.is_positional() && option.takes_files; });
}

/* Options that take a value, with what is known of it; the name means the same in every command. */
std::map<std::string, option_entry> valued_options(const std::vector<command_entry> &table)
{
    std::map<std::string, option_entry> found;
    for (const command_entry &command : table) {
        for (const option_entry &option : command.options) {
            if (!option.is_positional() && !option.value.empty() && found[option.name].words.empty()) {
                found[option.name] = option;
            }
        }
    }
    return found;
}

std::vector<std::string> names_of(const std::map<std::string, option_entry> &options)
{
    std::vector<std::string> names;
    names.reserve(options.size());
    for (const auto &[name, option] : options) {
        names.push_back(name);
    }
    return names;
}

/* readline ends words at = and : too, and replaces only what stands behind; files alone need its quotes. */
constexpr const char *bash_head =
    R"sh(# bash completion of berth; source it, or put it into a folder of bash-completion
_berth_offer() { # words; keeps of them what begins with the value
    local one
    while IFS= read -r one; do
        COMPREPLY+=("${one#"$kept"}")
    done < <(compgen -W "$1" -- "$value")
    [[ ${COMPREPLY[0]} != *= ]] || compopt -o nospace 2>/dev/null
}
_berth_offer_files() {
    local one
    compopt -o filenames 2>/dev/null
    while IFS= read -r one; do
        COMPREPLY+=("${one#"$kept"}")
    done < <(compgen -f -- "$value")
}
_berth() {
    local text=${COMP_LINE:0:COMP_POINT} breaks=${COMP_WORDBREAKS//[^=:]/} current value previous kept= words= files=
    local -a line
    local i places=0
    COMPREPLY=()
    read -a line <<< "$text"
    [[ $text != *[^\\]' ' ]] || line+=("")
    current=${line[${#line[@]} - 1]}
    case ${COMP_WORDS[COMP_CWORD]} in
    [\"\']*) current=${COMP_WORDS[COMP_CWORD]:1} ;;
    esac
    previous=${line[${#line[@]} - 2]}
    value=$current
    if [[ $current == --*=* ]]; then
        previous=${current%%=*} value=${current#*=}
    fi
    if [[ -n $breaks && $value == *["$breaks"]* ]]; then
        kept=${value%"${value##*["$breaks"]}"}
    fi
)sh";

std::string bash_script(const std::vector<command_entry> &table)
{
    const auto valued = valued_options(table);
    std::ostringstream script;
    script << bash_head << "    if [ \"${#line[@]}\" -eq 2 ]; then\n        _berth_offer '";
    for (const command_entry &command : table) {
        script << command.name << " ";
    }
    script << "--help --version'\n        return\n    fi\n    case $previous in\n";
    for (const auto &[name, option] : valued) {
        script << "    " << name << ")\n";
        if (!option.values.empty()) {
            script << "        if [[ $value == *=* ]]; then\n            _berth_offer '"
                   << joined_words(option.values) << "'\n            return\n        fi\n";
        }
        script << (option.words.empty() ? "" : "        _berth_offer '" + joined_words(option.words) + "'\n")
               << (option.takes_files ? "        _berth_offer_files\n" : "") << "        return ;;\n";
    }
    script << "    esac\n    for ((i = 2; i < ${#line[@]} - 1; i++)); do\n        case ${line[i]} in\n        "
           << joined_words(names_of(valued), "|")
           << ") i=$((i + 1)) ;;\n        -*) ;;\n        *) places=$((places + 1)) ;;\n        esac\n    done\n"
              "    case ${line[1]} in\n";
    for (const command_entry &command : table) {
        script << "    " << command.name << ") words='" << joined_words(option_names(command)) << "'\n"
               << (takes_files(command) ? "        files=yes\n" : "");
        if (const auto first = first_words(command); !first.empty()) {
            script << "        [ \"$places\" -gt 0 ] || words=\"$words " << joined_words(first) << "\"\n";
        }
        script << "        ;;\n";
    }
    script << "    esac\n"
              "    _berth_offer \"$words\"\n"
              "    if [ -n \"$files\" ] && [ \"${current:0:1}\" != - ]; then\n"
              "        _berth_offer_files\n"
              "    fi\n"
              "}\n"
              "complete -F _berth berth\n";
    return script.str();
}

/* "name:meaning", as _describe takes it. */
std::string zsh_entry(const std::string &name, const std::string &meaning)
{
    return quoted_for_shell(name + ":" + meaning, "'\\''");
}

/* What stands behind an option that takes a value. */
std::string zsh_value(const option_entry &option)
{
    const auto add = [](const std::vector<std::string> &words) {
        return "compadd " + std::string(words.front().back() == '=' ? "-S '' " : "") + "-- " + joined_words(words);
    };
    std::string actions;
    if (!option.values.empty()) {
        actions += "if [[ $PREFIX == *=* ]]; then " + add(option.values) + "; return; fi; ";
    }
    return actions + (option.words.empty() ? "" : add(option.words) + "; ") + (option.takes_files ? "_files; " : "");
}

std::string zsh_script(const std::vector<command_entry> &table)
{
    const auto valued = valued_options(table);
    std::ostringstream script;
    script
        << "#compdef berth\n# zsh completion of berth; source it behind compinit, or save it as _berth in a folder "
           "of $fpath\n_berth() {\n    local -a known\n    local files=\n    local -i i places=0\n"
           "    if (( CURRENT == 2 )); then\n        known=(\n";
    for (const command_entry &command : table) {
        script << "            " << zsh_entry(command.name, command.meaning) << "\n";
    }
    script << "        )\n        _describe command known\n        return\n    fi\n    case $words[CURRENT-1] in\n";
    for (const auto &[name, option] : valued) {
        script << "    " << name << ") " << zsh_value(option) << "return ;;\n";
    }
    script << "    esac\n    for ((i = 3; i < CURRENT; i++)); do\n        case $words[i] in\n        "
           << joined_words(names_of(valued), "|")
           << ") (( i++ )) ;;\n        -*) ;;\n        *) (( places++ )) ;;\n        esac\n    done\n"
              "    case $words[2] in\n";
    for (const command_entry &command : table) {
        script << "    " << command.name << ") known=(\n";
        for (const option_entry &option : command.options) {
            if (!option.is_positional()) {
                script << "        " << zsh_entry(option.name, option.meaning) << "\n";
            }
        }
        script << "    )\n";
        if (const auto first = first_words(command); !first.empty()) {
            script << "        (( places )) || compadd -- " << joined_words(first) << "\n";
        }
        script << (takes_files(command) ? "        files=yes\n" : "");
        script << "        ;;\n";
    }
    script << "    esac\n    _describe option known\n    [[ -z $files || $PREFIX == -* ]] || _files\n}\n"
              "if [[ $funcstack[1] == _berth ]]; then\n    _berth \"$@\"\nelse\n    compdef _berth berth\nfi\n";
    return script.str();
}

/* Which arguments an option takes, as `complete` of fish reads it. */
std::string fish_value(const option_entry &option)
{
    if (option.value.empty()) {
        return " -f";
    }
    const std::string words = !option.values.empty() ? "(__berth_settings)" : joined_words(option.words);
    return (option.takes_files ? " -r -F" : " -x") + (words.empty() ? "" : " -a " + quoted_for_shell(words, "\\'"));
}

/* Keys, and behind = the values of the key. */
std::string fish_settings(const option_entry &option)
{
    return "function __berth_settings\n"
           "    if string match -q '*=*' -- (commandline -ct)\n"
           "        string split ' ' '" +
           joined_words(option.values) + "'\n    else\n        string split ' ' '" + joined_words(option.words) +
           "'\n    end\nend\n";
}

std::string fish_script(const std::vector<command_entry> &table)
{
    const auto valued = valued_options(table);
    std::ostringstream script;
    script << "# fish completion of berth; save it as ~/.config/fish/completions/berth.fish\n"
              "function __berth_command\n"
              "    set -l words (commandline -opc)\n"
              "    test (count $words) -ge 2; and test $words[2] = $argv[1]\n"
              "end\n"
              "function __berth_begins\n"
              "    set -l words (commandline -opc)\n"
              "    set -l is_value 0\n"
              "    for word in $words[3..-1]\n"
              "        if test $is_value -eq 1\n"
              "            set is_value 0\n"
              "        else if contains -- $word "
           << joined_words(names_of(valued))
           << "\n"
              "            set is_value 1\n"
              "        else if not string match -q -- '-*' $word\n"
              "            return 1\n"
              "        end\n"
              "    end\n"
              "    test $is_value -eq 0\n"
              "end\n";
    for (const auto &[name, option] : valued) {
        script << (option.values.empty() ? "" : fish_settings(option));
    }
    script << "complete -c berth -f -n __fish_use_subcommand -l version -d 'print the version'\n";
    for (const command_entry &command : table) {
        script << "complete -c berth -f -n __fish_use_subcommand -a " << command.name << " -d "
               << quoted_for_shell(command.meaning, "\\'") << "\n";
        const std::string here = "complete -c berth -n '__berth_command " + command.name + "' ";
        script << (takes_files(command) ? "" : here + "-f\n");
        for (const option_entry &option : command.options) {
            if (!option.is_positional()) {
                script << here << "-l " << option.name.substr(2) << fish_value(option) << " -d "
                       << quoted_for_shell(option.meaning, "\\'") << "\n";
            } else if (!option.words.empty()) {
                script << "complete -c berth -n '__berth_command " << command.name << "; and __berth_begins' -a "
                       << quoted_for_shell(joined_words(option.words), "\\'") << "\n";
            }
        }
    }
    return script.str();
}

} // namespace

std::vector<std::string> shells()
{
    return {"bash", "zsh", "fish"};
}

std::string completion(const std::string &shell, const std::vector<command_entry> &table)
{
    return shell == "bash" ? bash_script(table) : shell == "zsh" ? zsh_script(table) : fish_script(table);
}

} // namespace berth
