#pragma once

#include <cstdint>
#include <string>
#include <systemc>
#include <vector>

#include "monitors/rule_reporter.h"
#include "monitors/violation.h"
#include "rtl/block.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// Watches one display's pipeline from its top composer to its output framebuffer (sections 4 and 5.4 of the paper),
/// without knowing what a composer does: STARTFRAME and raster pixels from stage to stage, and what the output
/// framebuffer receives and answers. Changes nothing.
///
/// Rules: pipeline/skew, pipeline/frame, pipeline/bubble, pipeline/outside, pipeready/framebuffer; docs/monitors.md
/// says what each means.
class PipelineMonitor final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<bool> column_stall_i{"column_stall_i"};
    sc_core::sc_vector<sc_core::sc_in<bool>> startframe_o;      ///< [renderer]: out of its composer
    sc_core::sc_vector<sc_core::sc_in<rtl::PipePixel>> pipe_o;  ///< [renderer]: out of its composer
    sc_core::sc_in<bool> pipeready_i{"pipeready_i"};            ///< of the output framebuffer

    /// display: index, from 0.
    PipelineMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int display,
                    ViolationLog& log);

    /// Frames that have come out of the pipeline in full.
    int frames_taken() const { return frames_taken_; }
    /// Clocks in which COLUMNSTALL was high, `stall` mode only.
    std::int64_t stalled_cycles() const { return stalled_cycles_; }
    std::int64_t unreported() const { return reporter_.unreported(); }

  private:
    void end_of_elaboration() override;
    void clock_edge();
    void restart();
    bool check_skew(std::int64_t edge);
    void check_framebuffer(std::int64_t edge);
    void take_pixel(std::int64_t edge);

    std::int64_t core_period_picoseconds_;
    bool may_stall_;
    std::int64_t raster_width_;
    std::int64_t raster_pixels_;
    std::string display_;  ///< "display 1"

    RuleReporter reporter_;
    std::vector<std::string> startframe_names_;
    std::vector<std::string> pipe_names_;
    std::string pipeready_name_;

    bool seen_reset_ = false;
    bool stood_still_ = false;              ///< COLUMNSTALL was high at the edge before
    std::vector<std::uint8_t> startframe_;  ///< [renderer]: as sampled one edge ago
    std::vector<std::uint8_t> valid_;       ///< [renderer]: the same of its pixel
    bool receiving_ = false;
    bool pipeready_ = false;        ///< as sampled one edge ago
    bool startframe_read_ = false;  ///< the output framebuffer has read STARTFRAME one edge ago
    std::int64_t raster_position_ = 0;
    int frame_ = -1;
    int frames_taken_ = 0;
    std::int64_t stalled_cycles_ = 0;
    rtl::Clocked clocked_{*this, clk_i, &PipelineMonitor::clock_edge};
};

}  // namespace metabuffer::monitors
