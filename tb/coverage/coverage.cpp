#include "coverage.h"

#include <stdexcept>

namespace metabuffer::coverage {

Goal& Coverage::declare(const GroupTitle& title, const std::string& name) {
    Group& group = groups_.try_emplace(title.name, Group{title.meaning, {}}).first->second;
    if (group.meaning != title.meaning) {
        throw std::logic_error(std::string("group ") + title.name + " has two meanings");
    }
    if (!full_names_.insert(full_name(title.name, name)).second) {
        throw std::logic_error("goal \"" + full_name(title.name, name) + "\" is there twice");
    }
    return group.goals.emplace_back(Goal{name, 0});
}

}  // namespace metabuffer::coverage
