/* From reset to main: stack, data, zeroed memory; and where exceptions go. */
	.option arch, +zicsr
	.section .start, "ax"
	.globl _start
_start:
	j begin

	/* Where the processor goes at an exception, of which there must be none. */
	.balign 4
exception:
	la sp, stack_end
	csrr a0, mcause
	csrr a1, mepc
	call trapped
0:	j 0b

begin:
	la sp, stack_end
	la a0, exception
	csrw mtvec, a0
	la a0, data_begin
	la a1, data_end
	la a2, data_image
1:	bgeu a0, a1, 2f
	lw a3, 0(a2)
	sw a3, 0(a0)
	addi a0, a0, 4
	addi a2, a2, 4
	j 1b
2:	la a0, bss_begin
	la a1, bss_end
3:	bgeu a0, a1, 4f
	sw zero, 0(a0)
	addi a0, a0, 4
	j 3b
4:	call main
5:	j 5b
