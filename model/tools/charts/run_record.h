#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "report/bus_use.h"
#include "report/report.h"
#include "scenario/scenario.h"
#include "tlm/schedule_observer.h"
#include "tools/charts/number_log.h"
#include "tools/charts/value_json.h"

namespace metabuffer::charts {

/// How much of a run a page shows in detail. What exceeds a limit is drawn from sums over bins of clocks, or it is left
/// out and counted.
struct RecordLimits {
    std::size_t bus_spans = 2'000'000;     ///< of all buses
    std::size_t level_points = 2'000'000;  ///< of all composers' buffers
    std::size_t starved_runs = 500'000;    ///< of all composers
    std::size_t stalls = 200'000;          ///< of all columns
    std::size_t link_frames = 100'000;     ///< of all links
};

/// The page's script identifies a use of the bus by its counter's name.
constexpr std::size_t kBusUses = kBusUseTable.size();

/// Clocks of each use, summed over bins of equally many clocks. Whenever there would be more than kMost bins, all bins
/// become twice as wide.
class ClockBins {
  public:
    static constexpr std::size_t kMost = 2048;

    void add(std::size_t use, CycleSpan span);
    std::int64_t width_cycles() const { return width_cycles_; }
    const std::vector<std::array<std::int64_t, kBusUses>>& bins() const { return bins_; }

  private:
    std::int64_t width_cycles_ = 1;
    std::vector<std::array<std::int64_t, kBusUses>> bins_;
};

/// The least and the most pixels that a buffer holds in each of such bins.
class LevelBins {
  public:
    void add(std::int64_t cycle, int level);
    std::int64_t width_cycles() const { return width_cycles_; }
    const std::vector<std::pair<int, int>>& bins() const { return bins_; }

  private:
    void widen(std::int64_t cycle);

    std::int64_t width_cycles_ = 1;
    std::int64_t last_cycle_ = 0;
    int last_level_ = 0;
    std::vector<std::pair<int, int>> bins_;
};

/// Records a run of level tlm for a page. The limits bound its memory, but for one span per frame and display.
class RunRecord final : public tlm::ScheduleObserver {
  public:
    explicit RunRecord(const Scenario& scenario, const RecordLimits& limits = {});

    void bus(int renderer, const tlm::BusSpan& span) override;
    void buffer_level(int renderer, int display, std::int64_t cycle, int held_pixels) override;
    void composited(int display, int frame, CycleSpan span) override;
    void column_stall(int display, int frame, CycleSpan span) override;
    void shown(int display, int frame, CycleSpan span) override;
    void link_frame(int renderer, const tlm::LinkFrameSeen& frame) override;
    void starved(int renderer, int display, const StarvedRun& run) override;

    /// The record as the page's script reads it. Long lists are bytes, deflated, as base64.
    Json json() const;

  private:
    struct BusTrack {
        NumberLog spans;
        std::size_t count = 0;
        std::int64_t end = 0;    ///< the clock after the last span in `spans`
        std::int64_t known = 0;  ///< no span before this clock is left out
        std::int64_t left_out = 0;
        ClockBins bins;
    };
    struct LevelTrack {
        NumberLog points;
        std::size_t count = 0;
        std::int64_t cycle = 0;
        int level = 0;
        std::int64_t known = 0;  ///< no point up to this clock is left out
        std::int64_t left_out = 0;
        LevelBins bins;
    };
    struct RunTrack {
        NumberLog runs;
        std::size_t count = 0;
        StarvedRun last;
        std::int64_t left_out = 0;
    };
    struct StallTrack {
        NumberLog spans;
        std::size_t count = 0;
        std::int64_t end = 0;
        std::int64_t left_out = 0;
    };
    struct LinkTrack {
        Json frames = Json::array();
        std::int64_t left_out = 0;
    };

    std::size_t composer(int renderer, int display) const {
        return static_cast<std::size_t>(renderer - 1) * displays_ + static_cast<std::size_t>(display - 1);
    }

    std::size_t displays_;
    RecordLimits room_;  ///< what is left of the limits
    std::vector<BusTrack> buses_;
    std::vector<LevelTrack> levels_;  ///< by renderer, then by display
    std::vector<RunTrack> starved_;   ///< by renderer, then by display
    std::vector<StallTrack> stalls_;  ///< by display
    std::vector<LinkTrack> links_;
    std::vector<std::vector<CycleSpan>> composited_;  ///< by frame, then by display
    std::vector<CycleSpan> shown_;                    ///< by frame: all displays swap together
};

}  // namespace metabuffer::charts
