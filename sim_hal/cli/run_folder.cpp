#include "run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "atomic_file.h"
#include "run_index_page.h"

namespace berth
{

namespace
{

namespace fs = std::filesystem;

constexpr const char *record_name = "run.json";
constexpr const char *latest_name = "latest";
constexpr const char *index_name = "index.html";

std::string local_time()
{
    const std::time_t now = std::time(nullptr);
    std::tm local{};
    localtime_r(&now, &local);
    char text[32];
    std::strftime(text, sizeof text, "%Y-%m-%dT%H-%M-%S", &local);
    return text;
}

/* What the rig has otherwise than a rig that states nothing: enough to say how two runs differ. */
nlohmann::json settings_of(const rig &of)
{
    const rig usual;
    nlohmann::json settings = nlohmann::json::object();
    for (const rig_key &key : rig_keys()) {
        if (const std::string text = value_text(of, key); text != value_text(usual, key)) {
            settings[std::string(key.path)] = text;
        }
    }
    return settings;
}

void write_whole(const fs::path &path, const std::string &text)
{
    atomic_file file(path.string());
    file.write(text);
    file.finish();
}

std::string as_text(const nlohmann::json &object)
{
    return object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/* Held while links, folders and the page change: runs may end at the same time. Where the file system has no locks,
 * nothing is held. */
class runs_lock
{
  public:
    explicit runs_lock(const fs::path &root) : folder_(open(root.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC))
    {
        while (folder_ >= 0 && flock(folder_, LOCK_EX) != 0 && errno == EINTR) {
        }
    }
    runs_lock(const runs_lock &) = delete;
    runs_lock &operator=(const runs_lock &) = delete;
    ~runs_lock()
    {
        if (folder_ >= 0) {
            close(folder_);
        }
    }

  private:
    int folder_;
};

/* When a run began, as its folder's name tells: 2026-11-29T23-40-05 and, of the tenth run of this second, -10. */
std::pair<std::string, int> start_of(const fs::path &folder)
{
    constexpr std::size_t time_length = std::string_view("2026-11-29T23-40-05").size();
    const std::string name = folder.filename().string();
    const std::string number = name.size() > time_length ? name.substr(time_length + 1) : "1";
    return {name.substr(0, time_length), static_cast<int>(std::strtol(number.c_str(), nullptr, 10))};
}

/* One more than that of any run of this second that stands in the rig's folder, is being made, or is named by
 * `latest`: `--keep` may have removed those before it, and their numbers would make a new run older than they. */
int next_number(const fs::path &rig_folder, const std::string &time)
{
    int highest = 0;
    const auto note = [&](const fs::path &run) {
        if (const auto [second, number] = start_of(run); second == time) {
            highest = std::max(highest, number);
        }
    };
    std::error_code error;
    for (const fs::directory_entry &entry : fs::directory_iterator(rig_folder, error)) {
        note(entry.path());
    }
    note(fs::read_symlink(rig_folder / latest_name, error));
    return highest + 1;
}

/* Folders of kept runs below `folder`, oldest first. */
std::vector<fs::path> run_folders(const fs::path &folder)
{
    std::vector<fs::path> found;
    std::error_code error;
    for (const fs::directory_entry &entry : fs::directory_iterator(folder, error)) {
        if (!entry.is_symlink(error) && fs::exists(entry.path() / record_name, error)) {
            found.push_back(entry.path());
        }
    }
    std::sort(found.begin(), found.end(), [](const auto &a, const auto &b) { return start_of(a) < start_of(b); });
    return found;
}

/* A run's row; null where its record cannot be read. */
nlohmann::json row_of(const fs::path &folder, const fs::path &root)
{
    const nlohmann::json record = nlohmann::json::parse(read_file((folder / record_name).string()), nullptr, false);
    if (!record.is_object()) {
        return nullptr;
    }
    nlohmann::json row = {
        {"folder", fs::relative(folder, root).string()}, {"time", folder.filename().string()}, {"report", nullptr}};
    for (const char *const key :
         {"rig", "verdict", "stable", "growth", "peak_force_N", "version", "config_hash", "settings"}) {
        row[key] = record.value(key, nlohmann::json());
    }
    if (!row["settings"].is_object()) {
        row["settings"] = nlohmann::json::object();
    }
    std::error_code error;
    const std::string page = row["rig"].is_string() ? row["rig"].get<std::string>() + ".html" : "";
    if (!page.empty() && fs::exists(folder / page, error)) {
        row["report"] = page;
    }
    return row;
}

/* Text of a script: no "</" ends it before its time. */
std::string within_script(std::string text)
{
    for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3) {
        text.replace(at, 2, "<\\/");
    }
    return text;
}

/* Of the keys that any run states. */
nlohmann::json defaults_of(const std::vector<nlohmann::json> &rows)
{
    const rig usual;
    nlohmann::json defaults = nlohmann::json::object();
    for (const nlohmann::json &row : rows) {
        for (const auto &setting : row["settings"].items()) {
            if (const rig_key *const known = find_key(setting.key())) {
                defaults[setting.key()] = value_text(usual, *known);
            }
        }
    }
    return defaults;
}

void write_index(const fs::path &root)
{
    std::vector<nlohmann::json> rows;
    std::error_code error;
    for (const fs::directory_entry &rig : fs::directory_iterator(root, error)) {
        for (const fs::path &folder : run_folders(rig.path())) {
            rows.push_back(row_of(folder, root));
        }
    }
    rows.erase(std::remove(rows.begin(), rows.end(), nullptr), rows.end());
    const nlohmann::json defaults = defaults_of(rows);
    std::stable_sort(rows.begin(), rows.end(), [](const auto &a, const auto &b) {
        return start_of(a["time"].template get<std::string>()) > start_of(b["time"].template get<std::string>());
    });
    write_whole(root / index_name, std::string(run_index_head) +
                                       "const root = " + within_script(as_text(root.string())) +
                                       ";\nconst defaults = " + within_script(as_text(defaults)) +
                                       ";\nconst runs = " + within_script(as_text(rows)) + ";\n" + run_index_script);
}

/* The link is replaced in one step: whoever reads it meanwhile finds the old run or the new one. */
void point_latest(const fs::path &folder)
{
    std::error_code error;
    const fs::path link = folder.parent_path() / latest_name;
    const fs::path next = link.string() + ".partial";
    fs::remove(next, error);
    fs::create_directory_symlink(folder.filename(), next, error);
    fs::rename(next, link, error);
    if (error) { /* a folder of this name stands there, and stays */
        fs::remove(next, error);
    }
}

} // namespace

std::string make_run_folder(const std::string &rig_name)
{
    if (rig_name == index_name) {
        throw input_error("name: \"" + rig_name +
                          "\" is the page of all runs; name the rig otherwise, or choose a "
                          "folder with --out");
    }
    const fs::path rig_folder = fs::path(kept_runs) / rig_name;
    std::error_code error;
    fs::create_directories(rig_folder, error);
    const runs_lock lock(kept_runs);
    const std::string time = local_time();
    for (int number = next_number(rig_folder, time); !error; number++) {
        const fs::path folder = rig_folder / (time + (number == 1 ? "" : "-" + std::to_string(number)));
        if (fs::create_directory(folder, error)) {
            return folder.string();
        }
    }
    throw input_error(rig_folder.string() + ": a folder for the run cannot be made there (" + error.message() +
                      "); choose another with --out");
}

std::string keep_run(const std::string &folder, const nlohmann::json &result, const rig &rig, std::int64_t keep)
{
    nlohmann::json record = result;
    record["settings"] = settings_of(rig);
    write_whole(fs::path(folder) / record_name, as_text(record) + "\n");
    const fs::path rig_folder = fs::path(folder).parent_path();
    const runs_lock lock(rig_folder.parent_path());
    const std::vector<fs::path> runs = run_folders(rig_folder);
    point_latest(runs.back());
    const std::size_t kept = keep > 0 ? static_cast<std::size_t>(keep) : runs.size();
    for (std::size_t i = 0; i + kept < runs.size(); i++) {
        std::error_code error;
        if (runs[i] != folder) { /* a run may end when newer ones are there; its log has just been promised */
            fs::remove_all(runs[i], error);
        }
    }
    write_index(rig_folder.parent_path());
    return (rig_folder.parent_path() / index_name).string();
}

/* The run that `latest` points to now, by its own name: a later run moves the link. Other folders as they are. */
static fs::path own_name(const fs::path &folder)
{
    std::error_code error;
    return folder.filename() == latest_name && fs::is_symlink(folder, error)
               ? folder.parent_path() / fs::read_symlink(folder, error)
               : folder;
}

/* A rig's name stands for its newest run, where nothing else goes by it. */
static fs::path named_run(const std::string &path)
{
    std::error_code error;
    const fs::path newest = fs::path(kept_runs) / path / latest_name;
    const bool is_name = !path.empty() && path.find('/') == std::string::npos && !fs::exists(path, error);
    return is_name && fs::is_directory(newest, error) ? newest : fs::path(path);
}

std::string log_of(const std::string &path)
{
    std::error_code error;
    const fs::path given = named_run(path);
    if (!fs::is_directory(given, error)) {
        return given.has_parent_path() ? own_name(given.parent_path()) / given.filename() : given;
    }
    const fs::path folder = own_name(given.has_filename() ? given : given.parent_path());
    std::vector<std::string> logs;
    for (const fs::directory_entry &entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".ulg") {
            logs.push_back(entry.path().string());
        }
    }
    if (logs.size() != 1) {
        throw input_error(path + ": cannot be read: it is a folder with " + std::to_string(logs.size()) +
                          " logs; name one .ulg file, or the folder of one run, as build/runs/ess/latest");
    }
    return logs.front();
}

void refresh_run_index(const std::string &log)
{
    std::error_code error;
    const fs::path folder = fs::canonical(log, error).parent_path();
    const fs::path root = folder.parent_path().parent_path();
    if (!error && fs::exists(folder / record_name, error) && fs::exists(root / index_name, error)) {
        const runs_lock lock(root);
        write_index(fs::relative(root, error));
    }
}

} // namespace berth
