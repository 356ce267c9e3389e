composer.sv
blend_counter.sv
blend_reciprocal.sv
pixel_blend.sv
-F composer_fifo.f
