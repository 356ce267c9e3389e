#pragma once

#include <memory>
#include <systemc>
#include <vector>

#include "tlm/payload.h"

namespace metabuffer::tlm {

/// A renderer's bus, from its input framebuffer to the composers of its row (section 5 of the paper): carries each
/// transfer to the composer of the display that the payload's address names, and notices back. It stands for wires and
/// adds no time.
class Bus final : public sc_core::sc_module {
  public:
    TargetSocket<Bus, BusTransfer> framebuffer_socket{"framebuffer_socket"};
    using ComposerSocket = InitiatorSocket<Bus, BusTransfer>;

    Bus(const sc_core::sc_module_name& name, int displays);

    /// To the composer of a display, from 1.
    ComposerSocket& composer_socket(int display) {
        return *composer_sockets_[static_cast<std::size_t>(display) - 1];
    }

  private:
    void b_transport(Payload& payload, sc_core::sc_time& delay);
    ::tlm::tlm_sync_enum nb_transport_bw(Payload& payload, Phase& phase, sc_core::sc_time& delay);

    std::vector<std::unique_ptr<ComposerSocket>> composer_sockets_;
};

}  // namespace metabuffer::tlm
