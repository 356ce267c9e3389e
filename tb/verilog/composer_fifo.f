composer_fifo.sv
fifo_memory.sv
pixel_bank.sv
