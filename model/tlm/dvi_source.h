#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "formats/dvi_timing.h"
#include "scenario/link_program.h"
#include "scenario/scenario.h"
#include "tlm/cycle.h"
#include "tlm/payload.h"

namespace metabuffer::tlm {

/// A renderer's graphics card as the link sees it, box A of the paper's Figure 1 (section 4): sends the
/// scenario's pairs frame by frame, with the faults that the scenario asks for. Timing as at level rtl: after
/// reset one vertical sync; in lockstep a pair starts at the clock that reads pair_request high.
class DviSource final : public sc_core::sc_module {
  public:
    InitiatorSocket<DviSource, DviFrame> link_socket{"link_socket"};
    sc_core::sc_in<bool> pair_request_i{"pair_request_i"};

    /// renderer: index, from 0. first_edge: the first DVI input clock without reset. The scenario must outlive
    /// the module.
    DviSource(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
              std::int64_t first_edge);
    SC_HAS_PROCESS(DviSource);

    /// One line for the watchdog: what the block waits for; empty if it waits for nothing.
    std::string waiting_for(std::int64_t picoseconds) const;

    /// Faults of the scenario that have taken effect on the link.
    std::int64_t injected_faults() const { return program_.injected_faults(); }

  private:
    enum class State : std::uint8_t { kFirstSync, kIdle, kSilence, kFrame };

    void process();
    void decide(std::int64_t edge);
    void send_frame(std::int64_t edge);
    void wake_at(std::int64_t edge);

    DviTiming timing_;
    LinkProgram program_;
    ClockDomain clock_;
    sc_core::sc_event wake_event_;

    State state_ = State::kFirstSync;
    std::int64_t next_edge_;  ///< the next clock with a decision
    Message<DviFrame> frame_;
    /// Images with flipped bits. They stay as long as this module: receivers of a frame identify its image by its
    /// address.
    std::vector<std::shared_ptr<const StoredImage>> images_;
};

}  // namespace metabuffer::tlm
