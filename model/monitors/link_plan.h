#pragma once

#include <cstdint>

#include "formats/control_scanline.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// The frames that a renderer's link sends, one after the other, as the scenario scripts them. With it a monitor can
/// distinguish intended faults from errors.
class LinkPlan {
  public:
    /// The scenario must outlive the plan. renderer: index, from 0.
    LinkPlan(const Scenario& scenario, int renderer) : scenario_(scenario), renderer_(renderer) {}

    struct Frame {
        std::int64_t pair = 0;
        FrameKind kind = FrameKind::kColour;
        bool corrupt = false;  ///< a fault changes its lines or their number
    };
    /// The next frame on the link. Frames that are not sent are left out; one that is sent twice comes twice.
    Frame next();
    /// The link starts again.
    void restart();

  private:
    template <typename Predicate>
    bool has_fault(Predicate concerned) const;
    void step();

    const Scenario& scenario_;
    int renderer_;
    std::uint32_t pair_ = 0;
    FrameKind kind_ = FrameKind::kColour;
    bool repeated_ = false;  ///< the frame has been sent once and comes again
};

}  // namespace metabuffer::monitors
