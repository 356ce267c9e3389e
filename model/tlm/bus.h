#pragma once

#include <tlm_utils/passthrough_target_socket.h>
#include <tlm_utils/simple_initiator_socket.h>

#include <memory>
#include <systemc>
#include <vector>

namespace metabuffer::tlm {

/// A renderer's bus, from its input framebuffer to the composers of its row (section 5 of the paper): takes each
/// transfer to the composer of the display that the payload's address names, and notices back. Wires, no time
/// of its own.
class Bus final : public sc_core::sc_module {
  public:
    ::tlm_utils::passthrough_target_socket<Bus> framebuffer_socket{"framebuffer_socket"};  ///< BusTransfer
    using ComposerSocket = ::tlm_utils::simple_initiator_socket<Bus>;

    Bus(const sc_core::sc_module_name& name, int displays);

    /// To the composer of a display, from 1.
    ComposerSocket& composer_socket(int display) {
        return *composer_sockets_[static_cast<std::size_t>(display) - 1];
    }

  private:
    void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
    ::tlm::tlm_sync_enum nb_transport_bw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                         sc_core::sc_time& delay);

    std::vector<std::unique_ptr<ComposerSocket>> composer_sockets_;
};

}  // namespace metabuffer::tlm
