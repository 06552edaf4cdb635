# Reading what Shutterlab wrote, and the table of differences.

# JSON as nested lists; an array of plain values becomes a vector, null NA.
read_json <- function(file) {
  text <- paste(readLines(file, encoding = "UTF-8", warn = FALSE), collapse = "\n")
  token <- "\"(?:[^\"\\\\]|\\\\.)*\"|[-+.0-9eE]+|true|false|null|[][{}:,]"
  tokens <- regmatches(text, gregexpr(token, text, perl = TRUE))[[1]]
  place <- 0
  take <- function() tokens[place <<- place + 1]
  unquote <- function(token) gsub("\\\\(.)", "\\1", substr(token, 2, nchar(token) - 1))
  members <- function(end, member) {
    found <- list()
    while (tokens[place + 1] != end) {
      found <- c(found, member())
      if (tokens[place + 1] == ",") take()
    }
    take()
    found
  }
  value <- function() {
    token <- take()
    switch(token,
      "{" = members("}", function() {
        name <- unquote(take())
        take()
        setNames(list(value()), name)
      }),
      "[" = {
        found <- members("]", function() list(value()))
        plain <- vapply(found, function(one) is.atomic(one) && length(one) == 1, TRUE)
        if (length(found) > 0 && all(plain)) unlist(found) else found
      },
      "true" = TRUE, "false" = FALSE, "null" = NA,
      if (startsWith(token, "\"")) unquote(token) else as.numeric(token))
  }
  value()
}

# One field of every element of a list, as a vector.
field <- function(list, ...) unlist(lapply(list, function(one) one[[c(...)]]))

# What an export holds, as its own load.R reads it.
read_export <- function(folder) {
  export <- new.env()
  capture.output(source(file.path(folder, "load.R"), local = export))
  droplevels(subset(export$responses, counts))
}

differences <- list()

# Adds what is compared: `ours` and `r` are vectors of the same values, `by` the function of R; `within` is
# the promised difference, in parts of `size`: each value itself if not said, so the difference is relative.
compare <- function(study, statistic, ours, r, by, within, size = abs(r)) {
  ours <- as.numeric(ours)
  r <- as.numeric(r)
  if (length(ours) != length(r) || length(r) == 0) {
    stop(study, ", ", statistic, ": ", length(ours), " values of ours, ", length(r), " of R")
  }
  difference <- ifelse(ours == r, 0, abs(ours - r) / size)
  difference[is.na(difference)] <- Inf
  worst <- which.max(difference)
  differences[[length(differences) + 1]] <<- data.frame(
    statistic, by, within, study, values = length(r), ours = ours[worst], r = r[worst],
    difference = max(difference))
}

# The table in Markdown, one row per statistic and function of R, with the study in which they differ most;
# whether every difference is as promised.
print_differences <- function() {
  all <- do.call(rbind, differences)
  key <- paste(all$statistic, all$by, all$within, sep = "\r")
  rows <- lapply(split(all, factor(key, unique(key))), function(rows) {
    worst <- rows[which.max(rows$difference), ]
    worst$values <- sum(rows$values)
    worst$studies <- nrow(rows)
    worst
  })
  rows <- do.call(rbind, rows)
  number <- function(x) vapply(x, function(x) format(signif(x, 7), digits = 7), "")
  kept <- rows$difference <= rows$within
  cells <- cbind(
    rows$statistic, rows$studies, rows$values, paste0("`", rows$by, "`"), rows$study, number(rows$ours),
    number(rows$r), ifelse(rows$difference == 0, "0", formatC(rows$difference, 0, format = "e")),
    ifelse(rows$within == 0, "equal", formatC(rows$within, format = "g")), ifelse(kept, "yes", "**no**"))
  header <- c("statistic", "times", "values", "in R", "most in", "ours", "R", "difference", "promised", "kept")
  right <- header %in% c("times", "values", "ours", "R", "difference", "promised")
  writeLines(paste("|", apply(rbind(header, ifelse(right, "---:", "---"), cells), 1, paste, collapse = " | "), "|"))
  cat(sprintf("\n%d comparisons of %d values; %d beyond what is promised.\n",
              nrow(all), sum(all$values), sum(all$difference > all$within)))
  all(kept)
}
