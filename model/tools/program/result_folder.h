#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/image.h"
#include "scenario/scenario.h"

namespace metabuffer {

/// The folder of the results. What had to be made of it goes again if the run fails before it wrote anything.
class ResultFolder {
  public:
    /// Throws InputError if it cannot be made.
    explicit ResultFolder(std::filesystem::path path);
    ResultFolder(const ResultFolder&) = delete;
    ResultFolder& operator=(const ResultFolder&) = delete;
    ~ResultFolder();

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
    std::vector<std::filesystem::path> made_;  ///< innermost first
};

/// Writes each frame's pictures as they come and keeps the newest for the collage, so that memory does not
/// grow with the number of frames. Throws OutputError.
class PictureSink {
  public:
    PictureSink(std::filesystem::path directory, const Scenario& scenario);

    void take(int frame, int display, const ColourImage& image);
    /// Behind the last picture. Pictures of an earlier run that this one has not written anew, since it has fewer
    /// frames or displays or was ended, are removed: they would pass for this one's.
    void finish() const;

  private:
    static constexpr int kNone = -1;

    /// display, frame: as in a file's name; frame: empty in that of a display's newest picture.
    bool is_of_earlier_run(const std::string& display, const std::string& frame) const;

    std::filesystem::path directory_;
    DisplayConfig config_;
    bool many_frames_;
    std::vector<ColourImage> newest_;  ///< by display
    std::vector<int> newest_frames_;   ///< by display
};

/// Removes the pictures of an earlier run from a folder, where they would pass for those of one that makes none.
void remove_pictures(const std::filesystem::path& directory);

}  // namespace metabuffer
