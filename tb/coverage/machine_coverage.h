#pragma once

#include <systemc>
#include <vector>

#include "arbiter_coverage.h"
#include "bus_coverage.h"
#include "column_coverage.h"
#include "composer_coverage.h"
#include "cover_group.h"
#include "display_coverage.h"
#include "fifo_coverage.h"
#include "handshake_coverage.h"
#include "link_coverage.h"
#include "memory_coverage.h"
#include "rtl/metabuffer.h"
#include "run_coverage.h"
#include "scenario/limits.h"
#include "scenario/scenario.h"
#include "shared_groups.h"

namespace metabuffer::coverage {

/// How a display's clock compares with the core clock.
enum class ClockRatio : std::uint8_t { kSlowerByWholeFactor, kSlower, kEqual, kFaster, kFasterByWholeFactor };

/// Of two periods, both above 0.
ClockRatio clock_ratio(std::int64_t core_picoseconds, std::int64_t out_picoseconds);

struct CombinationGoals : CoverGroup {
    explicit CombinationGoals(Coverage& coverage)
        : CoverGroup(coverage, {"bus/policy-width-ratio",
                                "frames for which composers competed for a bus: arbitration, width, display "
                                "clock, starvation"}) {}
    Cross<Arbitration, int, ClockRatio, StarvationMode> bins{
        *this,
        every<Arbitration>(),
        numbers(limits::kBusWidthsBits, " bits"),
        {{ClockRatio::kSlowerByWholeFactor, "DVI out slower by a whole factor"},
         {ClockRatio::kSlower, "DVI out slower"},
         {ClockRatio::kEqual, "DVI out equal"},
         {ClockRatio::kFaster, "DVI out faster"},
         {ClockRatio::kFasterByWholeFactor, "DVI out faster by a whole factor"}},
        every<StarvationMode>()};
};

struct ColumnsStallGoals : CoverGroup {
    explicit ColumnsStallGoals(Coverage& coverage) : CoverGroup(coverage, groups::kStall) {}
    Bin one_while_another_runs = bin("one column while another runs");
    Bin all_at_once = bin("all columns at once");
};

struct ColumnsReadyGoals : CoverGroup {
    explicit ColumnsReadyGoals(Coverage& coverage) : CoverGroup(coverage, groups::kPipeready) {}
    Bin same_clock = bin("columns at the same clock");
    Bin different_clocks = bin("columns at different clocks");
};

struct ColumnsSequenceGoals : CoverGroup {
    explicit ColumnsSequenceGoals(Coverage& coverage) : CoverGroup(coverage, groups::kSequence) {}
    Bin start_together = bin("columns start at the same clock");
    Bin start_apart = bin("columns start apart");
    Bin end_apart = bin("columns end apart");
};

/// Every goal there is.
struct MachineGoals : GoalSet {
    using GoalSet::GoalSet;
    CombinationGoals combination{coverage};
    ColumnsStallGoals columns_stall{coverage};
    ColumnsReadyGoals columns_ready{coverage};
    ColumnsSequenceGoals columns_sequence{coverage};
    BusGoals bus{coverage};
    ComposerGoals composer{coverage};
    ColumnGoals column{coverage};
    PairGoals link{coverage};
    SwapGoals display{coverage};
    HandshakeGoals handshake{coverage};
    MemoryCommandGoals memory{coverage};
    ArbiterGoals arbiter{coverage};
    FifoGoals fifo{coverage};
    RunGoals run{coverage};
};

/// Samples functional coverage of a whole machine at level rtl from outside: by its wires at every clock, and at the
/// run's end by scenario and report. It changes nothing in the machine.
class MachineCoverage final : public sc_core::sc_module {
  public:
    /// Machine and scenario must outlive it.
    MachineCoverage(const sc_core::sc_module_name& name, rtl::Metabuffer& machine, const Scenario& scenario);
    SC_HAS_PROCESS(MachineCoverage);

    /// The run has ended: counts what scenario and report show.
    void finished(const RunReport& report);

    const Coverage& counts() const { return coverage_; }
    /// The same, goal by goal.
    const MachineGoals& goals() const { return goals_; }

  private:
    void core_edge();
    void link_events();
    void sample_composers();
    void sample_buses();
    void sample_columns();
    void sample_displays();
    void sample_inner_wires();
    void sample_competition(std::size_t renderer, const ComposerCoverage& granted);
    void cover_combination(const RunReport& report);
    void cover_columns_together();

    rtl::Metabuffer& machine_;
    const Scenario& scenario_;
    std::size_t renderers_;
    std::size_t displays_;
    Coverage coverage_;
    MachineGoals goals_;
    std::vector<ComposerCoverage> composers_;  ///< renderer by renderer
    std::vector<BusCoverage> buses_;
    std::vector<LinkCoverage> links_;
    std::vector<ColumnCoverage> columns_;
    DisplayCoverage display_;
    HandshakeCoverage handshakes_;
    std::vector<MemoryCoverage> memories_;  ///< by renderer
    std::vector<ArbiterCoverage> arbiters_;
    std::vector<FifoCoverage> fifos_;                      ///< by composer
    std::vector<const sc_core::sc_signal<bool>*> stalls_;  ///< by composer, as the composer drives it
    std::vector<ColumnWires> column_wires_;                ///< as read at this edge
    std::vector<std::vector<const ComposerCoverage*>> column_composers_;  ///< by display, from the top
    DisplayWires display_wires_;
    std::vector<rtl::BusBeat> beats_;  ///< of the edge before
    std::vector<bool> tables_ready_;   ///< by renderer, at the edge before
    std::vector<int> frames_seen_;     ///< by renderer
    std::vector<const BusCoverage*> all_buses_;
    std::vector<bool> contested_;  ///< by frame: composers competed for a bus that sent it
};

}  // namespace metabuffer::coverage
