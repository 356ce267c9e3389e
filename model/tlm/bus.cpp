#include "tlm/bus.h"

#include <string>

namespace metabuffer::tlm {

Bus::Bus(const sc_core::sc_module_name& name, int displays) : sc_core::sc_module(name) {
    framebuffer_socket.register_b_transport(this, &Bus::b_transport);
    for (int display = 1; display <= displays; ++display) {
        composer_sockets_.push_back(
            std::make_unique<ComposerSocket>(("composer_socket_" + std::to_string(display)).c_str()));
        composer_sockets_.back()->register_nb_transport_bw(this, &Bus::nb_transport_bw);
    }
}

void Bus::b_transport(Payload& payload, sc_core::sc_time& delay) {
    composer_socket(static_cast<int>(payload.get_address()))->b_transport(payload, delay);
}

::tlm::tlm_sync_enum Bus::nb_transport_bw(Payload& payload, Phase& phase, sc_core::sc_time& delay) {
    return framebuffer_socket->nb_transport_bw(payload, phase, delay);
}

}  // namespace metabuffer::tlm
