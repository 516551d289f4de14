/* Functions that a cross-compiled Windows binary needs in addition to the system's libraries.  With them no C runtime
 * has to be linked, which would double the size of the binary.  No other build uses this file.
 */
#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

/* Loading and unloading: nothing to initialize. */
int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved)
{
    (void) library;
    (void) reason;
    (void) reserved;
    return 1;
}

/* Compilers refer to this symbol if floating-point numbers are used. */
int _fltused = 0;

int vsnprintf(char *text, size_t size, const char *format, va_list arguments)
{
    return __stdio_common_vsprintf(_CRT_INTERNAL_PRINTF_STANDARD_SNPRINTF_BEHAVIOR, text, size, format, NULL, arguments);
}

/* Used by isfinite and similar macros. */
int __fpclassify(double x)
{
    const double size = fabs(x);

    if (!(size <= DBL_MAX))
        return x != x ? FP_NAN : FP_INFINITE;
    return size >= DBL_MIN ? FP_NORMAL : size > 0.0 ? FP_SUBNORMAL : FP_ZERO;
}

/* Compilers replace a sine and a cosine by this call; volatile prevents that here. */
void sincos(double x, double *sine, double *cosine)
{
    const volatile double angle = x;

    *sine = sin(angle);
    *cosine = cos(angle);
}

/* Called before rax bytes of stack are allocated; changes no register.  Windows commits the stack page by page: each
   page must be touched in order. */
__asm__(".globl ___chkstk_ms\n"
        "___chkstk_ms:\n"
        "    pushq %rax\n"
        "    pushq %rcx\n"
        "    leaq 24(%rsp), %rcx\n"
        "1:  cmpq $4096, %rax\n"
        "    jb 2f\n"
        "    subq $4096, %rcx\n"
        "    orl $0, (%rcx)\n"
        "    subq $4096, %rax\n"
        "    jmp 1b\n"
        "2:  subq %rax, %rcx\n"
        "    orl $0, (%rcx)\n"
        "    popq %rcx\n"
        "    popq %rax\n"
        "    ret\n");
