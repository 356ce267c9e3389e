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

/// The folder of a run's results. What the run writes is kept aside in the folder, until put_in_place() replaces all
/// results of an earlier run with it. A run that fails leaves the earlier results as they are, and removes the folders
/// that were made for it.
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
    /// Call it once, after the last file. Replaces the results of an earlier run with those kept aside. Throws
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

/// The names of the files of results besides the pictures.
constexpr const char* kReportFile = "report.json";
constexpr const char* kEffectiveScenarioFile = "effective_scenario.yaml";

/// Whether runs write files of that name to a folder of results, and so may replace or remove them.
bool is_result_name(const std::string& name);

/// Writes the chosen frames' pictures as they arrive and keeps the newest for the collage, so that memory does not grow
/// with the number of frames. Construct it before the machine, since its processes copy the memory of this one. Throws
/// OutputError.
class PictureSink {
  public:
    PictureSink(ResultFolder& folder, const Scenario& scenario, const PictureChoice& choice);

    void take(int frame, int display, const ColourImage& image);
    /// Call it after the last picture.
    void finish();

  private:
    DisplayConfig config_;
    PictureChoice choice_;
    bool numbers_frames_;
    std::vector<ColourImage> newest_;  ///< by display
    PictureProcesses processes_;
};

}  // namespace metabuffer
