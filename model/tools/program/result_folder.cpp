#include "tools/program/result_folder.h"

#include <fmt/format.h>

#include <regex>
#include <string>
#include <system_error>
#include <utility>

#include "host/errors.h"
#include "report/picture_writer.h"

namespace metabuffer {
namespace {

constexpr const char* kCollage = "collage.png";

/// Removes the files whose names match; the predicate has the last word.
template <typename Unwanted>
void remove_files(const std::filesystem::path& directory, const std::regex& names, Unwanted unwanted) {
    for (const auto& entry : std::filesystem::directory_iterator(directory)) {
        std::smatch match;
        const std::string name = entry.path().filename().string();
        if (std::regex_match(name, match, names) && unwanted(match)) std::filesystem::remove(entry.path());
    }
}

}  // namespace

ResultFolder::ResultFolder(std::filesystem::path path) : path_(std::move(path)) {
    for (std::filesystem::path part = path_; !part.empty() && !std::filesystem::exists(part);
         part = part.parent_path()) {
        made_.push_back(part);
    }
    std::error_code error;
    std::filesystem::create_directories(path_, error);
    if (error) {
        throw InputError("--out " + path_.string() + ": cannot be made: " + error.message() +
                         "; name a folder in a place that can be written");
    }
}

ResultFolder::~ResultFolder() {
    std::error_code error;
    for (const std::filesystem::path& part : made_) {
        std::filesystem::remove(part, error);  // only if it is empty
    }
}

PictureSink::PictureSink(std::filesystem::path directory, const Scenario& scenario)
    : directory_(std::move(directory)),
      config_(scenario.displays),
      many_frames_(scenario.frames > 1),
      newest_(static_cast<std::size_t>(scenario.displays.count())),
      newest_frames_(newest_.size(), kNone) {}

void PictureSink::take(int frame, int display, const ColourImage& image) {
    const std::string stem = "display_" + std::to_string(display);
    if (many_frames_) {
        write_png(directory_ / fmt::format("{}.{:04}.png", stem, frame), image);
    }
    newest_[static_cast<std::size_t>(display) - 1] = image;
    newest_frames_[static_cast<std::size_t>(display) - 1] = frame;
}

bool PictureSink::is_of_earlier_run(const std::string& display, const std::string& frame) const {
    const unsigned long index = std::stoul(display) - 1;
    if (index >= newest_frames_.size()) return true;
    return frame.empty() ? newest_frames_[index] == kNone
                         : !many_frames_ || std::stol(frame) > newest_frames_[index];
}

void PictureSink::finish() const {
    remove_files(directory_, std::regex(R"(display_(\d{1,9})(?:\.(\d{4,9}))?\.png)"),
                 [this](const std::smatch& match) { return is_of_earlier_run(match[1], match[2]); });
    for (std::size_t d = 0; d < newest_.size(); ++d) {
        if (newest_[d].values.empty()) {  // the run ended before a frame was shown
            std::filesystem::remove(directory_ / kCollage);
            return;
        }
        write_png(directory_ / ("display_" + std::to_string(d + 1) + ".png"), newest_[d]);
    }
    write_png(directory_ / kCollage, collage(newest_, config_));
}

void remove_pictures(const std::filesystem::path& directory) {
    remove_files(directory, std::regex(R"(display_\d+(\.\d{4,})?\.png|collage\.png)"),
                 [](const std::smatch&) { return true; });
}

}  // namespace metabuffer
