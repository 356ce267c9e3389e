composer.sv
beat_receiver.sv
raster_walker.sv
merge_stage.sv
pipeline_handshake.sv
blend_counter.sv
blend_reciprocal.sv
pixel_blend.sv
-F composer_fifo.f
