const char *maze[] = {
    "939553",
    "a8453a",
    "8293aa",
    "aac2aa",
    "aad46a",
    "ec5556"
};
