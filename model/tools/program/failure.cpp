#include "tools/program/failure.h"

#include <exception>
#include <new>
#include <systemc>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer {

Failure current_failure() {
    try {
        throw;
    } catch (const InputError& error) {
        return {kExitBadInput, error.what()};
    } catch (const OutputError& error) {
        return {kExitBadInput, error.what()};
    } catch (const std::bad_alloc&) {
        return {kExitBadInput,
                "metabuffer: this computer does not have the memory for a machine of that size"};
    } catch (const sc_core::sc_report& report) {
        return {kExitModelError, text::one_line(std::string("the model is at fault: ") +
                                                report.get_msg_type() + ": " + report.get_msg())};
    } catch (const std::exception& error) {
        return {kExitModelError, text::one_line(std::string("the program is at fault: ") + error.what())};
    }
}

}  // namespace metabuffer
