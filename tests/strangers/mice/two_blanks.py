# Aligns its columns: mms ignores the first line, since x and y follow exactly one blank each.
print("setText  3 3 12")
print("setText 3 3  12")
