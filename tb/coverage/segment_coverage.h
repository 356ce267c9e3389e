#pragma once

#include "coverage.h"
#include "scenario/scenario.h"

namespace metabuffer::coverage {

/// Counts what a table that was composited holds: its rows, where their segments lie, and what was rejected.
void cover_table(Coverage& coverage, const Scenario& scenario, const Renderer& renderer,
                 const ViewportTable& table);

/// Counts where the viewport of a renderer's frame lies on the wall. The frame must have one.
void cover_viewport(Coverage& coverage, const Scenario& scenario, const Renderer& renderer,
                    const RendererFrame& frame);

}  // namespace metabuffer::coverage
