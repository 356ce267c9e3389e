#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "bus_coverage.h"
#include "column_coverage.h"
#include "composer_coverage.h"
#include "coverage.h"
#include "display_coverage.h"
#include "handshake_coverage.h"
#include "link_coverage.h"
#include "rtl/metabuffer.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

/// Samples functional coverage of a whole machine at level rtl from outside: by its wires at every clock, and at the
/// run's end by scenario and report. It changes nothing in the machine.
class MachineCoverage final : public sc_core::sc_module {
  public:
    /// Machine and scenario must outlive it.
    MachineCoverage(const sc_core::sc_module_name& name, rtl::Metabuffer& machine, const Scenario& scenario);
    SC_HAS_PROCESS(MachineCoverage);

    /// The run has ended: counts what scenario and report tell.
    void finished(const RunReport& report);

    const Coverage& counts() const { return coverage_; }

  private:
    void core_edge();
    void link_events();
    void sample_composers();
    void sample_buses();
    void sample_columns();
    void sample_displays();
    void sample_competition(std::size_t renderer, const ComposerCoverage& granted);
    void cover_combination(const RunReport& report);
    void cover_columns_together();

    rtl::Metabuffer& machine_;
    const Scenario& scenario_;
    std::size_t renderers_;
    std::size_t displays_;
    Coverage coverage_;
    std::vector<ComposerCoverage> composers_;  ///< renderer by renderer
    std::vector<BusCoverage> buses_;
    std::vector<LinkCoverage> links_;
    std::vector<ColumnCoverage> columns_;
    DisplayCoverage display_;
    HandshakeCoverage handshakes_;
    std::vector<const sc_core::sc_signal<bool>*> stalls_;  ///< by composer, as it drives it itself
    std::vector<ColumnWires> column_wires_;                ///< as read at this edge
    std::vector<std::vector<const ComposerCoverage*>> column_composers_;  ///< by display, from the top
    DisplayWires display_wires_;
    std::vector<rtl::BusBeat> beats_;  ///< of the edge before
    std::vector<bool> tables_ready_;   ///< by renderer, at the edge before
    std::vector<int> frames_seen_;     ///< by renderer
    std::vector<const BusCoverage*> all_buses_;
    std::vector<bool> contested_;  ///< by frame: composers competed for a bus that sent it
};

/// Coverage of a machine in a test, if METABUFFER_COVERAGE=DIR asks for it: what was counted goes to a file of the
/// process in DIR when the object goes. Outside of that nothing is built and nothing is sampled.
class CoverageRecorder {
  public:
    CoverageRecorder(rtl::Metabuffer& machine, const Scenario& scenario);
    CoverageRecorder(const CoverageRecorder&) = delete;
    CoverageRecorder& operator=(const CoverageRecorder&) = delete;
    ~CoverageRecorder();

    void finished(const RunReport& report);

  private:
    std::filesystem::path directory_;  ///< empty: not asked for
    std::unique_ptr<MachineCoverage> machine_coverage_;
};

}  // namespace metabuffer::coverage
