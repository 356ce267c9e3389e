#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "formats/image.h"
#include "host/writer_lock.h"
#include "report/picture_processes.h"
#include "scenario/scenario.h"
#include "tools/program/picture_choice.h"

namespace metabuffer {

/// The folder of the results of a run. It is whole at any time: what the run writes is kept aside in it, and put_in_place()
/// replaces all results of an earlier run by it. A run that fails leaves the earlier results, and of a folder that had to
/// be made for it nothing.
class ResultFolder {
  public:
    /// Throws InputError if it cannot be made, another process writes to it, or its results would replace an input.
    ResultFolder(std::filesystem::path path, const std::vector<std::filesystem::path>& inputs);
    ResultFolder(const ResultFolder&) = delete;
    ResultFolder& operator=(const ResultFolder&) = delete;
    ~ResultFolder();

    const std::filesystem::path& path() const { return path_; }

    /// Keeps a file aside; an earlier one of the same name is replaced. Throws OutputError.
    void write(const std::string& name, std::string_view bytes);
    /// Once, after the last file: results of an earlier run go, those that were kept aside take their place. Throws
    /// OutputError.
    void put_in_place();

  private:
    void make();
    void clear_leftovers() const;

    std::filesystem::path path_;
    std::filesystem::path aside_;
    std::vector<std::filesystem::path> made_;  ///< innermost first
    std::unique_ptr<WriterLock> lock_;
};

/// The names of the files of results beside the pictures.
constexpr const char* kReportFile = "report.json";
constexpr const char* kEffectiveScenarioFile = "effective_scenario.yaml";

/// Whether a file of that name in a folder of results is one that runs write, and may replace or remove.
bool is_result_name(const std::string& name);

/// Writes the chosen frames' pictures as they come and keeps the newest for the collage, so that memory does not grow with
/// the number of frames. Construct it before the machine, since its processes copy what this one has. Throws OutputError.
class PictureSink {
  public:
    PictureSink(ResultFolder& folder, const Scenario& scenario, const PictureChoice& choice);

    void take(int frame, int display, const ColourImage& image);
    /// After the last picture.
    void finish();

  private:
    DisplayConfig config_;
    PictureChoice choice_;
    bool numbers_frames_;
    std::vector<ColourImage> newest_;  ///< by display
    PictureProcesses processes_;
};

}  // namespace metabuffer
