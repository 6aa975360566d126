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
std::map<std::string, std::vector<std::string>> valued_options(const std::vector<command_entry> &table)
{
    std::map<std::string, std::vector<std::string>> found;
    for (const command_entry &command : table) {
        for (const option_entry &option : command.options) {
            if (!option.is_positional() && !option.value.empty() && found[option.name].empty()) {
                found[option.name] = option.words;
            }
        }
    }
    return found;
}

std::string bash_script(const std::vector<command_entry> &table)
{
    std::ostringstream script;
    script << "# bash completion of berth; source it, or put it into a folder of bash-completion\n"
              "_berth() {\n"
              "    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} words= files=\n"
              "    COMPREPLY=()\n"
              "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
              "        COMPREPLY=($(compgen -W '";
    for (const command_entry &command : table) {
        script << command.name << " ";
    }
    script << "--help --version' -- \"$current\"))\n        return\n    fi\n    case $previous in\n";
    for (const auto &[name, words] : valued_options(table)) {
        script << "    " << name << ")\n";
        if (words.empty()) {
            script << "        COMPREPLY=($(compgen -f -- \"$current\"))\n";
        } else {
            script << "        COMPREPLY=($(compgen -W '" << joined_words(words) << "' -- \"$current\"))\n";
        }
        script << (name == "--set" ? "        compopt -o nospace 2>/dev/null\n" : "") << "        return ;;\n";
    }
    script << "    esac\n    case ${COMP_WORDS[1]} in\n";
    for (const command_entry &command : table) {
        script << "    " << command.name << ") words='" << joined_words(option_names(command)) << "'\n"
               << (takes_files(command) ? "        files=-f\n" : "");
        if (const auto first = first_words(command); !first.empty()) {
            script << "        [ \"$COMP_CWORD\" -eq 2 ] && words=\"$words " << joined_words(first) << "\"\n";
        }
        script << "        ;;\n";
    }
    script << "    esac\n"
              "    COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
              "    if [ -n \"$files\" ] && [ \"${current:0:1}\" != - ]; then\n"
              "        COMPREPLY+=($(compgen -f -- \"$current\"))\n"
              "    fi\n"
              "}\n"
              "complete -o filenames -F _berth berth\n";
    return script.str();
}

/* "name:meaning", as _describe takes it. */
std::string zsh_entry(const std::string &name, const std::string &meaning)
{
    return quoted_for_shell(name + ":" + meaning, "'\\''");
}

std::string zsh_script(const std::vector<command_entry> &table)
{
    std::ostringstream script;
    script
        << "#compdef berth\n# zsh completion of berth; source it behind compinit, or save it as _berth in a folder "
           "of $fpath\n_berth() {\n    local -a known\n    local files=\n    if (( CURRENT == 2 )); then\n        "
           "known=(\n";
    for (const command_entry &command : table) {
        script << "            " << zsh_entry(command.name, command.meaning) << "\n";
    }
    script << "        )\n        _describe command known\n        return\n    fi\n    case $words[CURRENT-1] in\n";
    for (const auto &[name, words] : valued_options(table)) {
        script << "    " << name << ") ";
        script << (words.empty()
                       ? "_files"
                       : "compadd " + std::string(name == "--set" ? "-S '' " : "") + "-- " + joined_words(words))
               << "; return ;;\n";
    }
    script << "    esac\n    case $words[2] in\n";
    for (const command_entry &command : table) {
        script << "    " << command.name << ") known=(\n";
        for (const option_entry &option : command.options) {
            if (!option.is_positional()) {
                script << "        " << zsh_entry(option.name, option.meaning) << "\n";
            }
        }
        script << "    )\n";
        if (const auto first = first_words(command); !first.empty()) {
            script << "        (( CURRENT == 3 )) && compadd -- " << joined_words(first) << "\n";
        }
        script << (takes_files(command) ? "        files=yes\n" : "");
        script << "        ;;\n";
    }
    script << "    esac\n    _describe option known\n    [[ -z $files || $PREFIX == -* ]] || _files\n}\n"
              "if [[ $funcstack[1] == _berth ]]; then\n    _berth \"$@\"\nelse\n    compdef _berth berth\nfi\n";
    return script.str();
}

std::string fish_script(const std::vector<command_entry> &table)
{
    std::ostringstream script;
    script << "# fish completion of berth; save it as ~/.config/fish/completions/berth.fish\n"
              "function __berth_command\n"
              "    set -l words (commandline -opc)\n"
              "    test (count $words) -ge 2; and test $words[2] = $argv[1]\n"
              "end\n"
              "complete -c berth -f -n __fish_use_subcommand -l version -d 'print the version'\n";
    for (const command_entry &command : table) {
        script << "complete -c berth -f -n __fish_use_subcommand -a " << command.name << " -d "
               << quoted_for_shell(command.meaning, "\\'") << "\n";
        const std::string here = "complete -c berth -n '__berth_command " + command.name + "' ";
        script << (takes_files(command) ? "" : here + "-f\n");
        for (const option_entry &option : command.options) {
            const std::string words = quoted_for_shell(joined_words(option.words), "\\'");
            if (!option.is_positional()) {
                script << here << "-l " << option.name.substr(2)
                       << (option.value.empty()   ? " -f"
                           : option.words.empty() ? " -r -F"
                                                  : " -x -a " + words)
                       << " -d " << quoted_for_shell(option.meaning, "\\'") << "\n";
            } else if (!option.words.empty()) {
                script << "complete -c berth -n '__berth_command " << command.name
                       << "; and test (count (commandline -opc)) -eq 2' -a " << words << "\n";
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
