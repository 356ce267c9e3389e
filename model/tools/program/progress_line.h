#pragma once

#include <cstdint>
#include <string>

namespace metabuffer {

/// One line on a terminal that is overwritten as a run goes on, and removed when it ends. If stderr is not a terminal,
/// it shows nothing.
class ProgressLine {
  public:
    explicit ProgressLine(bool wanted);
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;
    ~ProgressLine();

    void show(const std::string& text) const;
    /// How far a run has come: core clocks done, and the share of its raster pixels composited.
    void show_run(std::int64_t core_cycles, double share) const;

  private:
    bool shown_;
};

}  // namespace metabuffer
