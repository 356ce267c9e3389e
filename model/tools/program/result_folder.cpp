#include "tools/program/result_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <regex>
#include <string>
#include <system_error>
#include <utility>

#include "host/child_process.h"
#include "host/errors.h"
#include "host/output_file.h"
#include "host/text.h"
#include "images/image_codec.h"
#include "report/picture_writer.h"
#include "tools/program/output_guard.h"

namespace metabuffer {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCollage = "collage.png";
constexpr const char* kAside = ".metabuffer-unfinished";
constexpr const char* kLock = ".metabuffer-lock";

/// The files in a folder that have names of results. A folder of such a name was not made by a run, and is left alone.
std::vector<fs::path> results_in(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator();
         entry.increment(error)) {
        std::error_code ignored;
        const bool is_folder = fs::is_directory(entry->symlink_status(ignored));
        if (!is_folder && is_result_name(entry->path().filename().string())) files.push_back(entry->path());
    }
    if (error) fail_to_write(folder, error.message());
    return files;
}

std::size_t pixels_of_display(const DisplayConfig& displays) {
    return static_cast<std::size_t>(displays.width_pixels) * static_cast<std::size_t>(displays.height_pixels);
}

/// What the collage says of itself: which displays' colours are corrected. Empty if none are.
std::string note_of_collage(const DisplayConfig& displays) {
    const std::vector<int> corrected = displays.corrected();
    if (corrected.empty()) return "";
    return "As the displays show it; colours corrected by displays.correction on display " +
           text::number_runs(corrected);
}

/// How many processes encode pictures: few for few pixels, since starting a process takes as long as encoding a small
/// picture.
std::size_t process_count(const Scenario& scenario, const PictureChoice& choice) {
    if (choice.none) return 0;
    constexpr std::size_t kWorthAProcessPixels = 200'000;
    const int frames = choice.each_frame ? choice.last_frame - choice.first_frame + 1 : 1;
    const std::size_t pixels = static_cast<std::size_t>(frames) *
                               static_cast<std::size_t>(scenario.displays.count()) *
                               pixels_of_display(scenario.displays);
    const std::size_t processes = std::min(helper_process_count(), pixels / kWorthAProcessPixels);
    // Started before those processes, since otherwise each of them would start it again.
    if (processes > 0) static_cast<void>(image_codec());
    return processes;
}

}  // namespace

bool is_result_name(const std::string& name) {
    static const std::regex pictures(R"(display_\d+(\.\d{4,})?\.png)");
    return name == kCollage || name == kReportFile || name == kEffectiveScenarioFile ||
           std::regex_match(name, pictures);
}

ResultFolder::ResultFolder(fs::path path, const std::vector<fs::path>& inputs)
    : path_(std::move(path)), aside_(path_ / kAside) {
    for (const fs::path& input : inputs) {
        std::error_code different;
        if (!fs::equivalent(input.has_parent_path() ? input.parent_path() : ".", path_, different)) continue;
        if (is_result_name(input.filename().string())) refuse_to_replace({input}, "--out", input);
    }
    try {
        make();
    } catch (...) {
        lock_.reset();
        std::error_code ignored;
        for (const fs::path& part : made_) fs::remove(part, ignored);
        throw;
    }
}

void ResultFolder::make() {
    std::error_code error;
    // A link that leads nowhere exists as well, and this object did not make it.
    for (fs::path part = path_;
         !part.empty() && fs::symlink_status(part, error).type() == fs::file_type::not_found;
         part = part.parent_path()) {
        made_.push_back(part);
    }
    fs::create_directories(path_, error);
    if (error) {
        throw InputError(text::one_line("--out " + path_.string() + ": cannot be made: " + error.message() +
                                        "; name a folder in a place that can be written"));
    }
    lock_ = std::make_unique<WriterLock>(path_ / kLock, "--out " + path_.string(),
                                         "wait for it, or name another folder");
    clear_leftovers();
    fs::create_directory(aside_, error);
    if (error) fail_to_write(aside_, error.message());
}

/// Removes what a run left that was killed.
void ResultFolder::clear_leftovers() const {
    std::error_code error;
    if (!fs::is_directory(fs::symlink_status(aside_, error))) return;
    fs::remove_all(aside_, error);
    if (error) fail_to_write(aside_, error.message());
}

ResultFolder::~ResultFolder() {
    std::error_code error;
    fs::remove_all(aside_, error);
    lock_.reset();
    for (const fs::path& part : made_) fs::remove(part, error);  // only if it is empty
}

void ResultFolder::write(const std::string& name, std::string_view bytes) {
    write_output_file(aside_ / name, bytes);
}

void ResultFolder::put_in_place() {
    // The report is removed first and put in place last: if there is a report, all pictures are of the same run.
    std::error_code error;
    fs::remove(path_ / kReportFile, error);
    if (error) fail_to_write(path_ / kReportFile, error.message());
    const std::vector<fs::path> results = results_in(aside_);
    for (const fs::path& earlier : results_in(path_)) {
        if (fs::exists(fs::status(aside_ / earlier.filename(), error))) continue;
        fs::remove(earlier, error);
        if (error) fail_to_write(earlier, error.message());
    }
    for (const fs::path& file : results) {
        if (file.filename() == kReportFile) continue;
        fs::rename(file, path_ / file.filename(), error);
        if (error) fail_to_write(path_ / file.filename(), error.message());
    }
    fs::rename(aside_ / kReportFile, path_ / kReportFile, error);
    if (error) fail_to_write(path_ / kReportFile, error.message());
}

PictureSink::PictureSink(ResultFolder& folder, const Scenario& scenario, const PictureChoice& choice)
    : config_(scenario.displays),
      choice_(choice),
      numbers_frames_(choice.each_frame && scenario.frames > 1),
      newest_(static_cast<std::size_t>(scenario.displays.count())),
      processes_({process_count(scenario, choice), 1, pixels_of_display(scenario.displays)},
                 [&folder, note = note_of_collage(scenario.displays)](const std::string& name,
                                                                      const ColourImage& picture) {
                     const std::string description = name == kCollage ? note : std::string();
                     folder.write(name, image_codec().png(picture, folder.path() / name, description));
                     return false;
                 }) {}

void PictureSink::take(int frame, int display, const ColourImage& image) {
    if (!choice_.holds(frame)) return;
    if (numbers_frames_) processes_.take(fmt::format("display_{}.{:04}.png", display, frame), image);
    newest_[static_cast<std::size_t>(display) - 1] = image;
}

void PictureSink::finish() {
    // If the run ended before every display showed a frame, there are no pictures of the last frame.
    const bool all_shown = std::none_of(newest_.begin(), newest_.end(),
                                        [](const ColourImage& picture) { return picture.values.empty(); });
    for (std::size_t d = 0; all_shown && d < newest_.size(); ++d) {
        processes_.take(fmt::format("display_{}.png", d + 1), newest_[d]);
    }
    if (all_shown) processes_.take(kCollage, collage(newest_, config_));
    processes_.finish();
}

}  // namespace metabuffer
