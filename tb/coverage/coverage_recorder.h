#pragma once

#include <filesystem>
#include <memory>

#include "report/report.h"
#include "rtl/metabuffer.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

class Coverage;
class MachineCoverage;

/// Every goal that a test of a machine can hit, none of them hit.
void declare_machine_goals(Coverage& coverage);

/// Coverage of a machine in a test, if METABUFFER_COVERAGE=DIR asks for it. When the object is destroyed, the counts go
/// to a file of the process in DIR. Without the variable nothing is built and nothing is sampled.
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
