#pragma once

#include <functional>
#include <string>
#include <systemc>
#include <utility>

#include "tlm/payload.h"

namespace metabuffer::test {

/// Drives a block's target socket, of the protocol whose extension is Content.
template <typename Content>
class Initiator final : public sc_core::sc_module {
  public:
    tlm::InitiatorSocket<Initiator, Content> socket{"socket"};

    explicit Initiator(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
        socket.register_nb_transport_bw(this, &Initiator::take_notice);
    }

    /// The response status after a blocking transport, which takes no time.
    ::tlm::tlm_response_status send(::tlm::tlm_generic_payload& payload) {
        sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
        socket->b_transport(payload, delay);
        return delay == sc_core::SC_ZERO_TIME ? payload.get_response_status()
                                              : ::tlm::TLM_GENERIC_ERROR_RESPONSE;
    }

    using Notice = std::function<void(::tlm::tlm_generic_payload&, const ::tlm::tlm_phase&)>;
    Notice on_notice;

  private:
    ::tlm::tlm_sync_enum take_notice(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                     sc_core::sc_time& /*delay*/) {
        if (on_notice) on_notice(payload, phase);
        return ::tlm::TLM_ACCEPTED;
    }
};

/// The other side of a block's initiator socket.
template <typename Content>
class Target final : public sc_core::sc_module {
  public:
    tlm::TargetSocket<Target, Content> socket{"socket"};

    explicit Target(const sc_core::sc_module_name& name) : sc_core::sc_module(name) {
        socket.register_b_transport(this, &Target::b_transport);
    }

    std::function<void(::tlm::tlm_generic_payload&)> on_transport;
    int transports = 0;

    void notify(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase phase) {
        sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
        socket->nb_transport_bw(payload, phase, delay);
    }

  private:
    void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& /*delay*/) {
        ++transports;
        if (on_transport) on_transport(payload);
        payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    }
};

/// Sockets are connected when the simulation starts.
inline void elaborate() { sc_core::sc_start(sc_core::SC_ZERO_TIME); }

/// The id of the error report that a call raises.
template <typename Call>
std::string report_of(const Call& call) {
    try {
        call();
    } catch (const sc_core::sc_report& report) {
        return report.get_severity() == sc_core::SC_ERROR ? report.get_msg_type() : "not an error";
    }
    return "no report";
}

/// The same of a payload without any extension.
template <typename Content>
std::string report_of_empty_payload(Initiator<Content>& initiator) {
    ::tlm::tlm_generic_payload payload;
    return report_of([&] { initiator.send(payload); });
}

constexpr const char* kExtensionReport = "/metabuffer/tlm/extension";

}  // namespace metabuffer::test
