#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "formats/image.h"
#include "functional/functional_compositor.h"
#include "report/picture_processes.h"
#include "report/report.h"
#include "scenario/scenario.h"

namespace metabuffer {

/// `metabuffer run --check` at a level without wires: compares the pictures that the displays show with those of the
/// functional level. Which pairs a frame was made of is known only at the end of the run. So pictures that differ from
/// those of a machine without time are kept until then, as many as fit into kKeptBytes. The others are not compared. A
/// picture in which something starved cannot be compared either.
///
/// The functional level composites in a process of its own while the run goes on, unless this computer has one core.
class PictureCheck {
  public:
    static constexpr std::size_t kKeptBytes = std::size_t{256} << 20;

    /// The scenario must outlive the check. Construct it before the machine, and with all images read: its process
    /// shares the memory that this one has now.
    explicit PictureCheck(const Scenario& scenario);

    void take(int frame, int display, const ColourImage& picture);
    /// Call it at the end of the run.
    void finish(const RunReport& report);

    const CheckRecord& record() const { return record_; }
    /// What was compared, for a summary; empty before finish().
    const std::string& compared() const { return compared_; }

  private:
    static PictureProcesses::Extent extent(const DisplayConfig& displays);

    ColourImage wanted(int frame, int display);
    void keep(int frame, int display, const ColourImage& picture);
    void judge(int frame, int display, const ColourImage& picture, const std::vector<int>& pairs,
               const RunReport& report);

    const Scenario& scenario_;
    std::vector<std::vector<int>> pairs_without_time_;
    functional::Compositor compositor_;
    int compositor_frame_ = -1;
    std::map<std::pair<int, int>, ColourImage> kept_;  ///< by frame and display
    std::size_t kept_bytes_ = 0;
    std::set<std::pair<int, int>> not_kept_;  ///< by frame and display
    std::int64_t taken_ = 0;
    std::int64_t starved_ = 0;
    CheckRecord record_;
    std::string compared_;
    PictureProcesses processes_;  ///< gives back the pictures that differ
};

}  // namespace metabuffer
